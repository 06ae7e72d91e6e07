#include <momentree/sweep/stats/statistics.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/base/check.hpp>

namespace momentree::sweep {
namespace {

bool is_smaller(const Extreme& a, const Extreme& b) { return a.value != b.value ? a.value < b.value : a.world < b.world; }
bool is_larger(const Extreme& a, const Extreme& b) { return a.value != b.value ? a.value > b.value : a.world < b.world; }

// Keeps the first `most` by `before` as a heap, the last of them on top.
template <class Before>
void keep_extreme(std::vector<Extreme>& heap, const Extreme& one, std::size_t most, Before before) {
  if (heap.size() == most) {
    if (most == 0 || !before(one, heap.front())) return;
    std::pop_heap(heap.begin(), heap.end(), before);
    heap.pop_back();
  }
  heap.push_back(one);
  std::push_heap(heap.begin(), heap.end(), before);
}

}  // namespace

Statistics::Statistics(std::size_t columns, StatisticsOptions options)
    : options_(options), columns_(columns), sample_(columns, options.kept, options.seed) {}

void Statistics::add(std::uint64_t world, std::span<const double> row) {
  sample_.add(world, row);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (!std::isfinite(row[i])) continue;
    Column& column = columns_[i];
    if (row[i] != 0) ++column.nonzero;
    column.moments.add(row[i]);
    keep_extreme(column.smallest, {row[i], world}, options_.extremes, is_smaller);
    keep_extreme(column.largest, {row[i], world}, options_.extremes, is_larger);
  }
}

void Statistics::merge(const Statistics& other) {
  MT_REQUIRE(columns() == other.columns() && options_.extremes == other.options_.extremes, "statistics of the same columns");
  sample_.merge(other.sample_);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    Column& column = columns_[i];
    const Column& added = other.columns_[i];
    column.nonzero += added.nonzero;
    column.moments.add(added.moments);
    for (const Extreme& one : added.smallest) keep_extreme(column.smallest, one, options_.extremes, is_smaller);
    for (const Extreme& one : added.largest) keep_extreme(column.largest, one, options_.extremes, is_larger);
  }
}

Summary Statistics::summary(std::size_t column) const {
  MT_REQUIRE(column < columns(), "a column of the statistics");
  const Column& from = columns_[column];
  Summary summary{from.moments.count(), worlds() - from.moments.count(), from.nonzero,
                  from.moments.mean(),  from.moments.deviation(),        from.smallest,
                  from.largest};
  std::sort(summary.smallest.begin(), summary.smallest.end(), is_smaller);
  std::sort(summary.largest.begin(), summary.largest.end(), is_larger);
  return summary;
}

}  // namespace momentree::sweep
