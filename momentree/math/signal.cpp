#include <momentree/math/signal.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <momentree/base/error.hpp>

namespace momentree {

namespace {

constexpr double full_turn = 2 * std::numbers::pi;

// The entry that ends the interval in which t lies: 0 before the first entry, size() from the last one on.
std::size_t after(std::span<const Signal::Knot> knots, double t) {
  return static_cast<std::size_t>(
      std::upper_bound(knots.begin(), knots.end(), t, [](double x, const Signal::Knot& k) { return x < k.time; }) -
      knots.begin());
}

// Slopes of the spline of second derivatives that are continuous, at rest at both ends: a tridiagonal system.
std::vector<double> spline_slopes(std::span<const Signal::Knot> knots) {
  const std::size_t n = knots.size();
  std::vector<double> slope(n, 0.0), factor(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double left = 1 / (knots[i].time - knots[i - 1].time), right = 1 / (knots[i + 1].time - knots[i].time);
    const double chord =
        3 * ((knots[i].value - knots[i - 1].value) * left * left + (knots[i + 1].value - knots[i].value) * right * right);
    const double pivot = 1 / (2 * (left + right) - left * factor[i - 1]);
    factor[i] = right * pivot;
    slope[i] = (chord - left * slope[i - 1]) * pivot;
  }
  for (std::size_t i = n; i-- > 1;) slope[i - 1] -= factor[i - 1] * slope[i];
  return slope;
}

}  // namespace

Signal Signal::table(std::vector<Knot> knots) {
  if (knots.empty()) fail({"a table needs an entry", "", "[[time, value], …]"});
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (!std::isfinite(knots[i].time) || !std::isfinite(knots[i].value))
      fail({"entry " + std::to_string(i + 1) + " of the table is not finite", "", ""});
    if (i > 0 && !(knots[i].time > knots[i - 1].time))
      fail({"the table's times must increase: entry " + std::to_string(i + 1) + " is not after the one before it", "",
            "for a jump, let the value rise within a very short time"});
  }
  Signal signal;
  if (knots.size() == 1)
    signal.offset_ = knots[0].value;
  else
    signal.table_ = std::make_shared<const std::vector<Knot>>(std::move(knots));
  return signal;
}

Signal Signal::sine(double amplitude, double frequency, double phase, double offset) {
  if (!std::isfinite(amplitude) || !std::isfinite(frequency) || !std::isfinite(phase) || !std::isfinite(offset))
    fail({"amplitude, frequency, phase and offset of a sine must be finite", "", ""});
  Signal signal(offset);
  signal.amplitude_ = amplitude, signal.frequency_ = frequency, signal.phase_ = phase;
  return signal;
}

double Signal::value(double t) const noexcept {
  if (!table_) return amplitude_ == 0 ? offset_ : offset_ + amplitude_ * std::sin(full_turn * frequency_ * t + phase_);
  const std::size_t i = after(*table_, t);
  if (i == 0) return table_->front().value;
  if (i == table_->size()) return table_->back().value;
  const Knot &a = (*table_)[i - 1], &b = (*table_)[i];
  const double x = (t - a.time) / (b.time - a.time);
  return (1 - x) * a.value + x * b.value;
}

double Signal::rate(double t) const noexcept {
  if (!table_) return amplitude_ == 0 ? 0 : amplitude_ * full_turn * frequency_ * std::cos(full_turn * frequency_ * t + phase_);
  const std::size_t i = after(*table_, t);
  if (i == 0 || i == table_->size()) return 0;
  const Knot &a = (*table_)[i - 1], &b = (*table_)[i];
  return (b.value - a.value) / (b.time - a.time);
}

double Signal::next_bend(double t) const noexcept {
  if (!table_) return HUGE_VAL;
  const std::size_t i = after(*table_, t);
  return i == table_->size() ? HUGE_VAL : (*table_)[i].time;
}

bool operator==(const Signal& a, const Signal& b) {
  const auto x = a.knots(), y = b.knots();
  return a.offset_ == b.offset_ && a.amplitude_ == b.amplitude_ && a.frequency_ == b.frequency_ && a.phase_ == b.phase_ &&
         std::equal(x.begin(), x.end(), y.begin(), y.end());
}

Curve::Curve(const Signal& signal) : signal_(signal) {
  if (!signal.knots().empty()) slopes_ = std::make_shared<const std::vector<double>>(spline_slopes(signal.knots()));
}

Curve::Point Curve::at(double t) const noexcept {
  const auto knots = signal_.knots();
  if (knots.empty()) {
    const double w = full_turn * signal_.frequency(), angle = w * t + signal_.phase(), a = signal_.amplitude();
    return {signal_.offset() + a * std::sin(angle), a * w * std::cos(angle), -a * w * w * std::sin(angle)};
  }
  const std::size_t i = after(knots, t);
  if (i == 0) return {knots.front().value, 0, 0};
  if (i == knots.size()) return {knots.back().value, 0, 0};
  // Hermite's cubic: x from 0 to 1 between the entries.
  const Signal::Knot &a = knots[i - 1], &b = knots[i];
  const double h = b.time - a.time, x = (t - a.time) / h, rise = b.value - a.value;
  const double s0 = h * (*slopes_)[i - 1], s1 = h * (*slopes_)[i];
  const double c2 = 3 * rise - 2 * s0 - s1, c3 = s0 + s1 - 2 * rise;
  return {a.value + x * (s0 + x * (c2 + x * c3)), (s0 + x * (2 * c2 + 3 * x * c3)) / h, (2 * c2 + 6 * x * c3) / (h * h)};
}

}  // namespace momentree
