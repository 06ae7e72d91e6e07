#pragma once
// Instants at equal intervals.

namespace momentree {

/// The instants from + k·period (s) for all integers k. Each is the double nearest to the decimal number: with a period of 0.05
/// s, the instant after 0.25 s is 0.3 s, not 0.30000000000000004 s. Numbers that are not short decimals are used as they are.
class Periodic {
 public:
  Periodic() = default;
  /// `period`: positive.
  Periodic(double from, double period);

  /// The first instant after `time`; if the clock cannot resolve the period there, the next time that it can.
  double first_after(double time) const;
  /// The first instant at `time` or after it.
  double first_from(double time) const;

 private:
  double instant(double k) const;

  double from_ = 0, period_ = 0;
  double scale_ = 1;  // a power of ten; `from_` and `period_` are multiples of its inverse
};

/// The instant `delay` (s, not negative) after `time`, in the same way: 0.1 s after 0.2 s is 0.3 s.
double delayed(double time, double delay);

}  // namespace momentree
