#pragma once
// A number that changes with time: values of drives and forces.
#include <memory>
#include <span>
#include <vector>

namespace momentree {

/// Constant, a ramp, a table, or a sine. Small, and copied without allocation. A table is a straight line between its entries and
/// keeps the values of its first and last entry beyond them; as a motion it is a smooth curve through them: see `Curve`.
class Signal {
 public:
  /// Entry of a table: time (s) and value.
  struct Knot {
    double time, value;
    friend bool operator==(const Knot&, const Knot&) = default;
  };

  /// How a table that is a motion begins and ends: at rest, or with the rates at which it passes its first and last entry, which
  /// it had before and keeps from then on.
  enum class Ends : unsigned char { rest, free };

  Signal(double constant = 0) : offset_(constant) {}  // NOLINT(google-explicit-constructor): .effort = 3.0
  /// Straight lines between entries. Throws Error: no entry, a number that is not finite, times that do not increase, free ends
  /// of a single entry.
  static Signal table(std::vector<Knot> knots, Ends ends = Ends::rest);
  /// offset + rate·t. Throws Error for what is not finite.
  static Signal ramp(double rate, double offset);
  /// The same as a motion that begins where the joint stands: at the start, when it is set, when a lock is opened.
  static Signal ramp_from_here(double rate);
  /// offset + amplitude·sin(2π·frequency·t + phase); frequency in 1/s, phase in rad. Throws Error for what is not finite.
  static Signal sine(double amplitude, double frequency, double phase = 0, double offset = 0);

  /// Value at time t (s).
  double value(double t) const noexcept;
  /// Slope of the same: at an entry of a table that of the line that follows.
  double rate(double t) const noexcept;
  bool constant() const { return table_ == nullptr && amplitude_ == 0 && ramp_ == 0; }
  /// The first instant after t at which a table bends; infinite where there is none.
  double next_bend(double t) const noexcept;

  /// What it was made of, to write it down.
  std::span<const Knot> knots() const { return table_ ? std::span<const Knot>(*table_) : std::span<const Knot>(); }
  double amplitude() const { return amplitude_; }
  double frequency() const { return frequency_; }
  double phase() const { return phase_; }
  double offset() const { return offset_; }
  double ramp_rate() const { return ramp_; }
  Ends ends() const { return ends_; }
  /// True for ramp_from_here; `begun_at` gives it its offset.
  bool from_here() const { return from_here_; }
  /// The same signal, from here: with `value` at time t. Others are what they are.
  Signal begun_at(double value, double t) const;
  friend bool operator==(const Signal& a, const Signal& b);

 private:
  double offset_ = 0, amplitude_ = 0, frequency_ = 0, phase_ = 0, ramp_ = 0;
  Ends ends_ = Ends::rest;
  bool from_here_ = false;
  std::shared_ptr<const std::vector<Knot>> table_;
};

/// A signal as a motion: with velocity and acceleration. A table becomes the cubic spline through its entries. One that starts
/// and ends at rest has a continuous value and velocity for ever, and a continuous acceleration between the first entry and the
/// last. One with free ends (the natural spline, with no acceleration there) goes on at a constant rate beyond them: value,
/// velocity and acceleration are continuous for ever.
class Curve {
 public:
  Curve() = default;
  explicit Curve(const Signal& signal);

  struct Point {
    double value, rate, acceleration;  ///< the acceleration at a bend is that which follows
  };
  Point at(double t) const noexcept;
  const Signal& signal() const { return signal_; }
  friend bool operator==(const Curve& a, const Curve& b) { return a.signal_ == b.signal_; }

 private:
  Signal signal_;
  std::shared_ptr<const std::vector<double>> slopes_;  // of a table, by entry
};

}  // namespace momentree
