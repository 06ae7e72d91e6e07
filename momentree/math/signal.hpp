#pragma once
// A number as a function of time: values of drives and forces.
#include <memory>
#include <span>
#include <vector>

namespace momentree {

/// A constant, a ramp, a table, or a sine. Small; copied without allocation. A table is linear between its entries and constant
/// before the first and after the last one; as a prescribed motion it is a smooth curve through the entries: see `Curve`.
class Signal {
 public:
  /// Entry of a table: time (s) and value.
  struct Knot {
    double time, value;
    friend bool operator==(const Knot&, const Knot&) = default;
  };

  /// How a table begins and ends as a prescribed motion: at rest, or with the rates that it has at its first and last entry,
  /// which then also apply before and after them.
  enum class Ends : unsigned char { rest, free };

  Signal(double constant = 0) : offset_(constant) {}  // NOLINT(google-explicit-constructor): .effort = 3.0
  /// Linear between entries. Throws Error: no entry, a number that is not finite, times that do not increase, free ends with a
  /// single entry.
  static Signal table(std::vector<Knot> knots, Ends ends = Ends::rest);
  /// offset + rate·t. Throws Error for numbers that are not finite.
  static Signal ramp(double rate, double offset);
  /// The same as a prescribed motion that starts at the joint's current position: at the start, when it is set, or when a lock is
  /// released.
  static Signal ramp_from_here(double rate);
  /// offset + amplitude·sin(2π·frequency·t + phase); frequency in 1/s, phase in rad. Throws Error for numbers that are not
  /// finite.
  static Signal sine(double amplitude, double frequency, double phase = 0, double offset = 0);

  /// Value at time t (s).
  double value(double t) const noexcept;
  /// Time derivative at t; at an entry of a table, that of the interval after it.
  double rate(double t) const noexcept;
  bool constant() const { return table_ == nullptr && amplitude_ == 0 && ramp_ == 0; }
  /// The first instant (s) after t at which a table has a kink; infinite if there is none.
  double next_bend(double t) const noexcept;

  /// The parameters from which it was made, for writing it to a file.
  std::span<const Knot> knots() const { return table_ ? std::span<const Knot>(*table_) : std::span<const Knot>(); }
  double amplitude() const { return amplitude_; }
  double frequency() const { return frequency_; }
  double phase() const { return phase_; }
  double offset() const { return offset_; }
  double ramp_rate() const { return ramp_; }
  Ends ends() const { return ends_; }
  /// True for ramp_from_here; `begun_at` sets its offset.
  bool from_here() const { return from_here_; }
  /// A ramp_from_here with the offset that gives `value` at time t; other signals unchanged.
  Signal begun_at(double value, double t) const;
  friend bool operator==(const Signal& a, const Signal& b);

 private:
  double offset_ = 0, amplitude_ = 0, frequency_ = 0, phase_ = 0, ramp_ = 0;
  Ends ends_ = Ends::rest;
  bool from_here_ = false;
  std::shared_ptr<const std::vector<Knot>> table_;
};

/// A signal as a prescribed motion: with velocity and acceleration. A table becomes the cubic spline through its entries. A
/// spline with ends at rest has a continuous value and velocity everywhere, and a continuous acceleration between the first and
/// the last entry. A spline with free ends (the natural spline, without acceleration there) continues at a constant rate beyond
/// them: value, velocity and acceleration are continuous everywhere.
class Curve {
 public:
  Curve() = default;
  explicit Curve(const Signal& signal);

  struct Point {
    double value, rate, acceleration;  ///< at a kink, the acceleration after it
  };
  Point at(double t) const noexcept;
  const Signal& signal() const { return signal_; }
  friend bool operator==(const Curve& a, const Curve& b) { return a.signal_ == b.signal_; }

 private:
  Signal signal_;
  std::shared_ptr<const std::vector<double>> slopes_;  // of a table, by entry
};

}  // namespace momentree
