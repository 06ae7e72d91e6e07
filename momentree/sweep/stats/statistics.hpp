#pragma once
// Statistics of the worlds of a sweep in bounded memory. Results depend neither on the order in which worlds are added nor on how
// they are split between objects that are merged later.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <momentree/sweep/stats/exact_sum.hpp>
#include <momentree/sweep/stats/sample.hpp>

namespace momentree::sweep {

struct StatisticsOptions {
  std::size_t kept = 100'000;  ///< worlds whose values are kept: quantiles and correlations are exact up to this number
  std::size_t extremes = 10;   ///< smallest and largest values that are listed
  std::uint64_t seed = 0;      ///< chooses the worlds to keep when there are more
};

struct Extreme {
  double value;
  std::uint64_t world;
};

/// Of one column. Values that are not finite count as missing. Numbers that do not exist are NaN: the mean of no values, the
/// deviation of one.
struct Summary {
  std::uint64_t count = 0, missing = 0;
  std::uint64_t nonzero = 0;                   ///< of `count`
  double mean = 0, deviation = 0;              ///< from exact sums; the sample deviation (n - 1)
  std::vector<Extreme> smallest{}, largest{};  ///< from the most extreme one on; of equal values the first worlds
};

class Statistics {
 public:
  /// `columns`: numbers per world, of varied values and measures alike.
  explicit Statistics(std::size_t columns, StatisticsOptions options = {});

  /// One number per column. Each world is added once. NaN: missing.
  void add(std::uint64_t world, std::span<const double> row);
  /// Adds the worlds of `other`, which has the same columns and options and no world in common.
  void merge(const Statistics& other);

  std::size_t columns() const { return columns_.size(); }
  std::uint64_t worlds() const { return sample_.offered(); }
  Summary summary(std::size_t column) const;
  /// All worlds or a random sample of them, for quantiles, histograms and correlations.
  const Sample& sample() const { return sample_; }

 private:
  struct Column {
    std::uint64_t nonzero = 0;
    ExactMoments moments;
    std::vector<Extreme> smallest, largest;  // heaps, the least extreme one first
  };
  StatisticsOptions options_;
  std::vector<Column> columns_;
  Sample sample_;
};

}  // namespace momentree::sweep
