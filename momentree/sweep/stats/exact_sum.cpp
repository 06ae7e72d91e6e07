#include <momentree/sweep/stats/exact_sum.hpp>

#include <bit>
#include <cmath>
#include <limits>

#include <momentree/base/check.hpp>

namespace momentree::sweep {
namespace {

constexpr std::int64_t digit_mask = 0xFFFFFFFF;
constexpr int lowest_exponent = -1074;  // of the smallest positive double
using Digits = std::vector<std::uint32_t>;

// |x| = (high · 2^27 + low) · 2^(position - 1074)
struct Parts {
  std::uint64_t high, low;
  int position;
  bool negative;
  explicit Parts(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const int biased = static_cast<int>(bits >> 52 & 0x7FF);
    const std::uint64_t mantissa = (bits & ((std::uint64_t{1} << 52) - 1)) | std::uint64_t{biased > 0} << 52;
    high = mantissa >> 27;
    low = mantissa & ((1u << 27) - 1);
    position = biased > 0 ? biased - 1 : 0;
    negative = bits >> 63;
  }
};

// A non-negative integer as mantissa · 2^exponent, from its highest 64 bits.
struct Rounded {
  double mantissa;
  int exponent;
};
Rounded rounded(const Digits& digits) {
  std::size_t top = digits.size();
  while (top > 0 && digits[top - 1] == 0) --top;
  if (top == 0) return {0, 0};
  const auto digit = [&](std::size_t below) { return below <= top ? std::uint64_t{digits[top - below]} : 0; };
  const int shift = std::countl_zero(digits[top - 1]);
  std::uint64_t bits = digit(1) << 32 | digit(2);
  if (shift > 0) bits = bits << shift | digit(3) >> (32 - shift);
  return {static_cast<double>(bits), 32 * (static_cast<int>(top) - 2) - shift};
}

Digits product(const Digits& a, const Digits& b) {
  Digits result(a.size() + b.size(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::uint64_t carry = 0;
    for (std::size_t j = 0; j < b.size(); ++j) {
      carry += std::uint64_t{a[i]} * b[j] + result[i + j];
      result[i + j] = static_cast<std::uint32_t>(carry);
      carry >>= 32;
    }
    result[i + b.size()] = static_cast<std::uint32_t>(carry);
  }
  return result;
}

// a - b, for a >= b.
Digits difference(Digits a, const Digits& b) {
  std::int64_t borrow = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    borrow += std::int64_t{a[i]} - (i < b.size() ? b[i] : 0);
    a[i] = static_cast<std::uint32_t>(borrow & digit_mask);
    borrow >>= 32;
  }
  return a;
}

}  // namespace

template <std::size_t Size>
void ExactSum<Size>::add(std::uint64_t magnitude, int position, bool negative) {
  if (++pending_ > 1u << 30) carry();
  const auto at = static_cast<std::size_t>(position / 32);
  const int shift = position % 32;
  const std::int64_t sign = negative ? -1 : 1;
  digits_[at] += sign * (static_cast<std::int64_t>(magnitude << shift) & digit_mask);
  digits_[at + 1] += sign * (static_cast<std::int64_t>(magnitude >> (32 - shift)) & digit_mask);
  if (shift > 0) digits_[at + 2] += sign * static_cast<std::int64_t>(magnitude >> (64 - shift));
}

template <std::size_t Size>
void ExactSum<Size>::add(const ExactSum& other) {
  ExactSum addend = other;
  addend.carry();
  carry();
  for (std::size_t i = 0; i < Size; ++i) digits_[i] += addend.digits_[i];
  pending_ = 1;
}

template <std::size_t Size>
void ExactSum<Size>::carry() {
  for (std::size_t i = 0; i + 1 < Size; ++i) {
    digits_[i + 1] += digits_[i] >> 32;
    digits_[i] &= digit_mask;
  }
  pending_ = 0;
}

template <std::size_t Size>
std::vector<std::uint32_t> ExactSum<Size>::digits(bool& negative) const {
  ExactSum sum = *this;
  sum.carry();
  negative = sum.digits_.back() < 0;
  if (negative) {
    for (std::int64_t& digit : sum.digits_) digit = -digit;
    sum.carry();
  }
  return {sum.digits_.begin(), sum.digits_.end()};
}

void ExactMoments::add(double x) {
  MT_REQUIRE(std::isfinite(x), "a finite number");
  ++count_;
  const Parts parts(x);
  sum_.add(parts.high << 27 | parts.low, parts.position, parts.negative);
  squares_.add(parts.low * parts.low, 2 * parts.position, false);
  squares_.add(parts.low * parts.high, 2 * parts.position + 28, false);
  squares_.add(parts.high * parts.high, 2 * parts.position + 54, false);
}

void ExactMoments::add(const ExactMoments& other) {
  count_ += other.count_;
  sum_.add(other.sum_);
  squares_.add(other.squares_);
}

double ExactMoments::mean() const {
  if (count_ == 0) return std::numeric_limits<double>::quiet_NaN();
  const auto share = [&](const ExactSum<68>& sum) {
    bool negative = false;
    const auto [mantissa, exponent] = rounded(sum.digits(negative));
    const double size = std::ldexp(mantissa / static_cast<double>(count_), exponent + lowest_exponent);
    return negative ? -size : size;
  };
  // The second step, with the exact remainder, takes the error of the first division away.
  const double first = share(sum_);
  const Parts parts(first);
  ExactSum<68> remainder = sum_;
  for (const int half : {0, 32}) {
    const std::uint64_t times = count_ >> half & 0xFFFFFFFF;
    remainder.add(parts.low * times, parts.position + half, !parts.negative);
    remainder.add(parts.high * times, parts.position + half + 27, !parts.negative);
  }
  return first + share(remainder);
}

double ExactMoments::deviation() const {
  if (count_ < 2) return std::numeric_limits<double>::quiet_NaN();
  bool negative = false;
  const Digits sum = sum_.digits(negative), squares = squares_.digits(negative);
  const Digits count{static_cast<std::uint32_t>(count_), static_cast<std::uint32_t>(count_ >> 32)};
  // n (n - 1) times the variance
  auto [mantissa, exponent] = rounded(difference(product(squares, count), product(sum, sum)));
  const int even = (exponent & 1) ? exponent - 1 : exponent;
  if (even != exponent) mantissa *= 2;
  const double n = static_cast<double>(count_);
  return std::ldexp(std::sqrt(mantissa / n / (n - 1)), even / 2 + lowest_exponent);
}

template class ExactSum<68>;
template class ExactSum<136>;

}  // namespace momentree::sweep
