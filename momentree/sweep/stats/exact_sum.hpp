#pragma once
// Exact sums of doubles, which therefore do not depend on the order of the terms.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace momentree::sweep {

/// A sum of integers times powers of two, without rounding: digits of 32 bits with room for carries.
template <std::size_t Digits>
class ExactSum {
 public:
  /// Adds ±magnitude · 2^position, position >= 0, magnitude < 2^63.
  void add(std::uint64_t magnitude, int position, bool negative);
  void add(const ExactSum& other);
  /// Digits of the absolute value, the lowest first, and its sign.
  std::vector<std::uint32_t> digits(bool& negative) const;

 private:
  void carry();
  std::array<std::int64_t, Digits> digits_{};
  std::uint32_t pending_ = 0;  ///< additions since the last carry
};

/// Mean and variance of finite doubles.
class ExactMoments {
 public:
  void add(double x);
  void add(const ExactMoments& other);
  std::uint64_t count() const { return count_; }
  /// Correctly rounded but for rare cases, where the error is less than a unit in the last place. NaN without values.
  double mean() const;
  /// Sample standard deviation (n - 1). NaN for fewer than two values.
  double deviation() const;

 private:
  std::uint64_t count_ = 0;
  ExactSum<68> sum_;       // in units of 2^-1074
  ExactSum<136> squares_;  // in units of 2^-2148
};

}  // namespace momentree::sweep
