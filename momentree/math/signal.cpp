#include <momentree/math/signal.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <momentree/base/error.hpp>
#include <momentree/math/sine_cosine.hpp>

namespace momentree {

namespace {

constexpr double full_turn = 2 * std::numbers::pi;

// The entry at the end of the interval that contains t: 0 before the first entry, size() from the last one on.
std::size_t after(std::span<const Signal::Knot> knots, double t) {
  return static_cast<std::size_t>(
      std::upper_bound(knots.begin(), knots.end(), t, [](double x, const Signal::Knot& k) { return x < k.time; }) -
      knots.begin());
}

// Slopes of the spline with a continuous second derivative: a tridiagonal system. At the ends the slope (rest) or the second
// derivative (free) is zero.
std::vector<double> spline_slopes(std::span<const Signal::Knot> knots, Signal::Ends ends) {
  const std::size_t n = knots.size();
  std::vector<double> slope(n, 0.0), factor(n, 0.0);
  const bool free = ends == Signal::Ends::free;
  const auto chord_slope = [&](std::size_t i) {
    return (knots[i + 1].value - knots[i].value) / (knots[i + 1].time - knots[i].time);
  };
  if (free) slope[0] = 1.5 * chord_slope(0), factor[0] = 0.5;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double left = 1 / (knots[i].time - knots[i - 1].time), right = 1 / (knots[i + 1].time - knots[i].time);
    const double chord =
        3 * ((knots[i].value - knots[i - 1].value) * left * left + (knots[i + 1].value - knots[i].value) * right * right);
    const double pivot = 1 / (2 * (left + right) - left * factor[i - 1]);
    factor[i] = right * pivot;
    slope[i] = (chord - left * slope[i - 1]) * pivot;
  }
  if (free) slope[n - 1] = (3 * chord_slope(n - 2) - slope[n - 2]) / (2 - factor[n - 2]);
  for (std::size_t i = n; i-- > 1;) slope[i - 1] -= factor[i - 1] * slope[i];
  return slope;
}

}  // namespace

Signal Signal::table(std::vector<Knot> knots, Ends ends) {
  if (knots.empty()) throw_error({"a table needs an entry", "", "[[time, value], …]"});
  if (knots.size() == 1 && ends == Ends::free) throw_error({"a table with free ends needs two entries", "", "[[0, 0], [1, 2]]"});
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (!std::isfinite(knots[i].time) || !std::isfinite(knots[i].value))
      throw_error({"entry " + std::to_string(i + 1) + " of the table is not finite", "", ""});
    if (i > 0 && !(knots[i].time > knots[i - 1].time))
      throw_error({"the table's times must increase: entry " + std::to_string(i + 1) + " is not after the one before it", "",
                   "for a jump, let the value rise within a very short time"});
  }
  Signal signal;
  signal.ends_ = ends;
  if (knots.size() == 1)
    signal.offset_ = knots[0].value;
  else
    signal.table_ = std::make_shared<const std::vector<Knot>>(std::move(knots));
  return signal;
}

Signal Signal::sine(double amplitude, double frequency, double phase, double offset) {
  if (!std::isfinite(amplitude) || !std::isfinite(frequency) || !std::isfinite(phase) || !std::isfinite(offset))
    throw_error({"amplitude, frequency, phase and offset of a sine must be finite", "", ""});
  Signal signal(offset);
  signal.amplitude_ = amplitude, signal.frequency_ = frequency, signal.phase_ = phase;
  return signal;
}

Signal Signal::ramp(double rate, double offset) {
  if (!std::isfinite(rate) || !std::isfinite(offset)) throw_error({"rate and offset of a ramp must be finite", "", ""});
  Signal signal(offset);
  signal.ramp_ = rate;
  return signal;
}

Signal Signal::ramp_from_here(double rate) {
  Signal signal = ramp(rate, 0);
  signal.from_here_ = true;
  return signal;
}

Signal Signal::begun_at(double value, double t) const {
  Signal signal = *this;
  if (from_here_) signal.offset_ = value - ramp_ * t;
  return signal;
}

double Signal::value(double t) const noexcept {
  if (ramp_ != 0) return offset_ + ramp_ * t;
  if (!table_) return amplitude_ == 0 ? offset_ : offset_ + amplitude_ * sine_cosine(full_turn * frequency_ * t + phase_).s;
  const std::size_t i = after(*table_, t);
  if (i == 0) return table_->front().value;
  if (i == table_->size()) return table_->back().value;
  const Knot &a = (*table_)[i - 1], &b = (*table_)[i];
  const double x = (t - a.time) / (b.time - a.time);
  return (1 - x) * a.value + x * b.value;
}

double Signal::rate(double t) const noexcept {
  if (ramp_ != 0) return ramp_;
  if (!table_)
    return amplitude_ == 0 ? 0 : amplitude_ * full_turn * frequency_ * sine_cosine(full_turn * frequency_ * t + phase_).c;
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
         a.ramp_ == b.ramp_ && a.ends_ == b.ends_ && a.from_here_ == b.from_here_ &&
         std::equal(x.begin(), x.end(), y.begin(), y.end());
}

Curve::Curve(const Signal& signal) : signal_(signal) {
  if (!signal.knots().empty())
    slopes_ = std::make_shared<const std::vector<double>>(spline_slopes(signal.knots(), signal.ends()));
}

Curve::Point Curve::at(double t) const noexcept {
  const auto knots = signal_.knots();
  if (knots.empty()) {
    if (signal_.ramp_rate() != 0) return {signal_.value(t), signal_.ramp_rate(), 0};
    const double w = full_turn * signal_.frequency(), angle = w * t + signal_.phase(), a = signal_.amplitude();
    const auto [s, c] = sine_cosine(angle);
    return {signal_.offset() + a * s, a * w * c, -a * w * w * s};
  }
  const std::size_t i = after(knots, t);
  const auto beyond = [t](const Signal::Knot& end, double rate) { return Point{end.value + rate * (t - end.time), rate, 0}; };
  if (i == 0) return beyond(knots.front(), slopes_->front());
  if (i == knots.size()) return beyond(knots.back(), slopes_->back());
  // Cubic Hermite polynomial: x from 0 to 1 between the entries.
  const Signal::Knot &a = knots[i - 1], &b = knots[i];
  const double h = b.time - a.time, x = (t - a.time) / h, rise = b.value - a.value;
  const double s0 = h * (*slopes_)[i - 1], s1 = h * (*slopes_)[i];
  const double c2 = 3 * rise - 2 * s0 - s1, c3 = s0 + s1 - 2 * rise;
  return {a.value + x * (s0 + x * (c2 + x * c3)), (s0 + x * (2 * c2 + 3 * x * c3)) / h, (2 * c2 + 6 * x * c3) / (h * h)};
}

}  // namespace momentree
