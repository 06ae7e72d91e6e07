#pragma once
// A number that changes with time: what drives and forces are told.
#include <memory>
#include <span>
#include <vector>

namespace momentree {

/// Constant, a table, or a sine. Small, and copied without allocation. A table is a straight line between its entries, or, where
/// rates are asked for, a smooth curve through them: see `Curve`. Before its first entry and after its last one it keeps their
/// values.
class Signal {
 public:
  /// Entry of a table: time (s) and value.
  struct Knot {
    double time, value;
    friend bool operator==(const Knot&, const Knot&) = default;
  };

  Signal(double constant = 0) : offset_(constant) {}  // NOLINT(google-explicit-constructor): .effort = 3.0
  /// Straight lines between entries. Throws Error: no entry, a number that is not finite, times that do not increase.
  static Signal table(std::vector<Knot> knots);
  /// offset + amplitude·sin(2π·frequency·t + phase); frequency in 1/s, phase in rad. Throws Error for what is not finite.
  static Signal sine(double amplitude, double frequency, double phase = 0, double offset = 0);

  /// Value at time t (s).
  double value(double t) const noexcept;
  /// Slope of the same: at an entry of a table that of the line that follows.
  double rate(double t) const noexcept;
  bool constant() const { return table_ == nullptr && amplitude_ == 0; }
  /// The first instant after t at which a table bends; infinite where there is none.
  double next_bend(double t) const noexcept;

  /// What it was made of, to write it down.
  std::span<const Knot> knots() const { return table_ ? std::span<const Knot>(*table_) : std::span<const Knot>(); }
  double amplitude() const { return amplitude_; }
  double frequency() const { return frequency_; }
  double phase() const { return phase_; }
  double offset() const { return offset_; }
  friend bool operator==(const Signal& a, const Signal& b);

 private:
  double offset_ = 0, amplitude_ = 0, frequency_ = 0, phase_ = 0;
  std::shared_ptr<const std::vector<Knot>> table_;
};

/// A signal as a motion: with velocity and acceleration. A table becomes the cubic spline through its entries that starts and
/// ends at rest: value and velocity are continuous for ever, the acceleration between the first entry and the last.
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
