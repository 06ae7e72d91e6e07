#pragma once
// Probability distributions by their quantiles, so that one uniform number gives one value, whatever method drew it.
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace momentree::sweep {

/// Closed interval, in the unit of the values.
struct Interval {
  double lowest, highest;
};

struct Uniform {
  double from, to;
};
struct Normal {
  double mean, deviation;
  std::optional<Interval> within{};  ///< values outside are excluded: a truncated normal distribution
};
/// `mean` and `deviation` are those of the natural logarithm of the values.
struct Lognormal {
  double mean, deviation;
};
struct Exponential {
  double mean;
};
struct Weibull {
  double scale, shape;
};
struct Triangular {
  double least, mode, greatest;
};
/// Beta distribution with shapes a and b, stretched from [0, 1] to `within`.
struct Beta {
  double a, b;
  Interval within{0, 1};
};
/// The index of a weight, with a probability in proportion to it.
struct Choice {
  std::vector<double> weights;
};

/// An immutable distribution. Values are finite. Only arithmetic and the C library's exp, log, pow, sqrt and erfc are used.
class Distribution {
 public:
  using Kind = std::variant<Uniform, Normal, Lognormal, Exponential, Weibull, Triangular, Beta, Choice>;

  /// Throws Error, without a place, for parameters that are impossible or not finite.
  Distribution(Kind kind);  // NOLINT(google-explicit-constructor)
  template <class One>
  requires std::is_constructible_v<Kind, One> Distribution(One one)
      : Distribution(Kind(std::move(one))) {}  // NOLINT(google-explicit-constructor)

  const Kind& kind() const { return kind_; }
  /// The value below which a share u of the values lies, 0 < u < 1. Increases with u.
  double quantile(double u) const;
  /// The share of the values <= x.
  double cdf(double x) const;
  double mean() const;
  /// Standard deviation.
  double deviation() const;
  /// "uniform 8 to 24", "normal 1 ± 0.1 within 0.5 to 2".
  std::string text() const;

 private:
  Kind kind_;
  std::vector<double> cumulative_;  ///< of Choice
};

}  // namespace momentree::sweep
