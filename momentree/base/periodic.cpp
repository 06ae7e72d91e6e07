#include <momentree/base/periodic.hpp>

#include <algorithm>
#include <cmath>

namespace momentree {

namespace {

// The smallest power of ten whose product with this number is whole, if the number is the double nearest to a decimal number of
// at most 15 digits, which is then unique; otherwise 0. Powers up to 10²² are exact, and so is the comparison.
double decimal_scale(double x) {
  for (double scale = 1; scale <= 1e22; scale *= 10) {
    const double digits = std::nearbyint(x * scale);
    if (!(std::abs(digits) < 1e15)) return 0;
    if (digits / scale == x) return scale;
  }
  return 0;
}

}  // namespace

Periodic::Periodic(double from, double period) : from_(from), period_(period) {
  const double of_from = decimal_scale(from), of_period = decimal_scale(period);
  if (of_from == 0 || of_period == 0) return;
  const double scale = std::max(of_from, of_period);
  const double first = std::nearbyint(from * scale), step = std::nearbyint(period * scale);
  if (std::abs(first) < 1e15 && step < 1e15) from_ = first, period_ = step, scale_ = scale;
}

// Sums of whole numbers are exact up to 2⁵³, and a quotient is rounded once.
double Periodic::instant(double k) const {
  const double passed = k * period_;
  return (from_ + passed) / scale_;
}

double Periodic::first_after(double time) const {
  const double near = std::floor((time * scale_ - from_) / period_);
  for (const double offset : {-1, 0, 1, 2})
    if (const double at = instant(near + offset); at > time) return at;
  return std::nextafter(time, HUGE_VAL);
}

double Periodic::first_from(double time) const { return first_after(std::nextafter(time, -HUGE_VAL)); }

double delayed(double time, double delay) { return time + delay > time ? Periodic(time, delay).first_after(time) : time; }

}  // namespace momentree
