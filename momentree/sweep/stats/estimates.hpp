#pragma once
// Estimates from columns of a sample. Numbers that are not finite are left out.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <momentree/sweep/stats/distribution.hpp>

namespace momentree::sweep {

/// Finite values in ascending order.
std::vector<double> sorted(std::span<const double> values);

/// The quantile at `share` (0 … 1) of sorted values, interpolated linearly as NumPy does by default; NaN without values.
double quantile(std::span<const double> sorted, double share);

/// Counts of values between evenly spaced edges. A value on an inner edge belongs to the bin above it.
struct Histogram {
  std::vector<double> edges;  ///< one more than counts; both empty without values
  std::vector<std::uint64_t> counts;
};
/// Bins of about the width of Freedman and Diaconis, rounded to 1, 2 or 5 times a power of 10, at most `most`.
Histogram histogram(std::span<const double> sorted, std::size_t most = 50);

/// Spearman's rank correlation of pairs, with average ranks for ties. None: fewer than three pairs, or one side is constant.
std::optional<double> rank_correlation(std::span<const double> x, std::span<const double> y);

/// First-order Sobol index: the share of the variance of y that x explains on average, 0 … 1, from the means of y in bins of x of
/// equal counts, corrected for their bias. It is complete only if x varies independently of the other varied values. None: fewer
/// than ten pairs, or one side is constant.
std::optional<double> sobol_index(std::span<const double> x, std::span<const double> y);

/// Wilson's interval for the probability of a success at the 95 % level; [0, 1] without trials.
Interval wilson_interval(std::uint64_t successes, std::uint64_t trials);

}  // namespace momentree::sweep
