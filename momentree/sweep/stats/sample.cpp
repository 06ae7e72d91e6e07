#include <momentree/sweep/stats/sample.hpp>

#include <algorithm>
#include <numeric>

#include <momentree/base/check.hpp>
#include <momentree/sweep/stats/random.hpp>

namespace momentree::sweep {

Sample::Sample(std::size_t columns, std::size_t capacity, std::uint64_t seed)
    : columns_(columns), capacity_(capacity), seed_(mix(seed + 0x9E3779B97F4A7C15)) {}

void Sample::add(std::uint64_t world, std::span<const double> row) {
  MT_REQUIRE(row.size() == columns_, "a number per column");
  ++offered_;
  keep({mix(world ^ seed_), world, 0}, row);
}

void Sample::keep(Entry entry, std::span<const double> row) {
  if (entries_.size() < capacity_) {
    entry.place = entries_.size();
    rows_.insert(rows_.end(), row.begin(), row.end());
  } else {
    if (capacity_ == 0 || !(entry < entries_.front())) return;
    std::pop_heap(entries_.begin(), entries_.end());
    entry.place = entries_.back().place;
    entries_.pop_back();
    std::copy(row.begin(), row.end(), rows_.begin() + static_cast<std::ptrdiff_t>(entry.place * columns_));
  }
  entries_.push_back(entry);
  std::push_heap(entries_.begin(), entries_.end());
}

void Sample::merge(const Sample& other) {
  MT_REQUIRE(columns_ == other.columns_ && capacity_ == other.capacity_ && seed_ == other.seed_, "samples of the same kind");
  offered_ += other.offered_;
  for (const Entry& entry : other.entries_) keep(entry, std::span(other.rows_).subspan(entry.place * columns_, columns_));
}

std::vector<Sample::Entry> Sample::in_order() const {
  std::vector<Entry> entries = entries_;
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.world < b.world; });
  return entries;
}

std::vector<std::uint64_t> Sample::worlds() const {
  std::vector<std::uint64_t> worlds;
  for (const Entry& entry : in_order()) worlds.push_back(entry.world);
  return worlds;
}

std::vector<std::size_t> Sample::smallest(std::size_t count) const {
  const std::vector<Entry> entries = in_order();
  std::vector<std::size_t> places(entries.size());
  std::iota(places.begin(), places.end(), std::size_t{0});
  if (count < places.size()) {
    const auto end = places.begin() + static_cast<std::ptrdiff_t>(count);
    std::nth_element(places.begin(), end, places.end(), [&](std::size_t a, std::size_t b) { return entries[a] < entries[b]; });
    places.erase(end, places.end());
    std::sort(places.begin(), places.end());
  }
  return places;
}

std::vector<double> Sample::column(std::size_t column) const {
  MT_REQUIRE(column < columns_, "a column of the sample");
  std::vector<double> values;
  for (const Entry& entry : in_order()) values.push_back(rows_[entry.place * columns_ + column]);
  return values;
}

}  // namespace momentree::sweep
