// Locates, within a step, the instant at which a stop is hit or must release its joint, or at which a condition is met or ceases
// to hold. Trial steps of the integrator itself are used, so that the state found is a state of the motion.
#include <algorithm>
#include <cmath>
#include <limits>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/simulate/events/stops.hpp>

namespace momentree {

namespace {

constexpr int most_samples = 256;  // of a condition within a step

// The maximum within a step of h seconds, and its time, by the cubic through the end values and rates q0, v0 > 0, q1, v1 < 0.
struct Peak {
  double time, value;
};
Peak peak_between(double h, double q0, double v0, double q1, double v1) {
  const double rise = q1 - q0, a = v0 * h, b = 3 * rise - 2 * v0 * h - v1 * h, c = -2 * rise + v0 * h + v1 * h;
  const double x = std::clamp(a / (std::sqrt(std::max(b * b - 3 * a * c, 0.0)) - b), 0.0, 1.0);
  return {x * h, q0 + x * (a + x * (b + x * c))};
}

// The cubic with these values and rates at 0 and h, at time s.
double cubic_between(double h, double q0, double v0, double q1, double v1, double s) {
  const double x = s / h, rise = q1 - q0;
  return q0 + x * (v0 * h + x * (3 * rise - (2 * v0 + v1) * h + x * ((v0 + v1) * h - 2 * rise)));
}

// Two instants, before and beyond the crossing, and the excess there.
struct Bracket {
  double inside, within, outside, beyond;
};
// Narrows the bracket to a width of `tolerance` by the Illinois variant of the secant method, kept away from the ends so that
// both of them move; bisects when convergence is slow, for example when rounding makes the value a step function. `value(s)` may
// be empty on failure; this function then returns false. `guess`: first point to evaluate.
template <class Value>
bool narrow(Bracket& b, double tolerance, std::optional<double> guess, Value value) {
  double width = b.outside - b.inside;  // three evaluations ago
  for (int last = 0, look = 1; b.outside - b.inside > tolerance; guess.reset(), ++look) {
    bool halve = (b.within == 0 && last != 0) || !(b.beyond > b.within);
    if (look % 3 == 0) {
      halve = halve || b.outside - b.inside > 0.25 * width;
      width = b.outside - b.inside;
    }
    const double margin = std::min(0.25 * (b.outside - b.inside), 0.4 * tolerance);
    const double secant = (b.inside * b.beyond - b.outside * b.within) / (b.beyond - b.within);
    halve = halve || !std::isfinite(secant);  // a quantity may be infinite
    const double s = halve ? b.inside + 0.5 * (b.outside - b.inside)
                           : std::clamp(guess.value_or(secant), b.inside + margin, b.outside - margin);
    const std::optional<double> found = value(s);
    if (!found) return false;
    if (*found > 0) {
      b.outside = s, b.beyond = *found;
      if (last > 0) b.within /= 2;
      last = 1;
    } else {
      b.inside = s, b.within = *found;
      if (last < 0) b.beyond /= 2;
      last = -1;
    }
  }
  return true;
}

}  // namespace

// Steps from one start to several ends.
struct Stops::Trial {
  World& world;
  Evaluator& evaluate;
  Integrator& method;
  EnergyLedger& ledger;
  const State& start;
  EnergyLedger books_at_start;
  bool accelerations;
  double at = 0;     ///< seconds from the start to the world's present state; NaN if that is not an end of a step
  double reach = 0;  ///< length of the method's last step
  State& end;        ///< of the method's last step, once it has been interpolated
  EnergyLedger books_at_end{};
  double kept = 0;  ///< when that is, seconds from the start
  bool done = false;
  // Restores the world unless the step was accepted: also if a condition's function threw.
  ~Trial() {
    if (done) return;
    method.return_to_start();
    world.edit().state() = start;
    ledger = books_at_start;
  }

  // As far as the method itself goes; empty if it failed.
  bool first(double most) {
    evaluate(world.edit().state());
    at = reach = method.advance(evaluate, world.edit().state(), ledger, most);
    return at > 0 && look();
  }
  bool go(double s) {
    if (s == kept && s == reach) {
      world.edit().state() = end;
      ledger = books_at_end;
      at = s;
      return look();
    }
    method.return_to_start();
    world.edit().state() = start;
    ledger = books_at_start;
    at = reach = s;
    evaluate(world.edit().state());
    return method.step(evaluate, world.edit().state(), ledger, s) && look();
  }
  // The same by dense output of the last step, if the method has it: for evaluation only; the run cannot continue from there.
  bool see(double s) {
    if (!method.dense() || s > reach) return go(s);
    if (at == reach) end = world.edit().state(), books_at_end = ledger, kept = at;
    {
      const State::Edit edit = world.edit().state().edit();
      method.interpolate(evaluate, s / reach, edit.q.data(), edit.y.data());
      edit.time = start.time() + s;
    }
    at = NAN;
    return look();
  }
  bool look() {
    evaluate(world.edit().state());
    if (accelerations) accelerate(world.tree(), world.edit().state(), world.edit().workspace());
    return true;
  }
};

// Positive beyond the stop, or if the stop would have to pull.
double Stops::excess(const Watched& w) const {
  if (w.watch != nullptr) {
    const std::optional<double> value = w.watch->condition->excess(*world_, {});
    return value ? w.watch->sign * (*value + w.watch->offset) : w.watch->start;
  }
  return w.held ? pull(*w.side) : w.side->sign * coordinate(*w.side) - w.limit;
}

// Values, and rates if they cost nothing, at the end of the step, which is the world's present state.
void Stops::look_at_end(std::size_t first) {
  for (std::size_t i = first; i < watched_.size(); ++i) {
    Watched& w = watched_[i];
    w.last = excess(w);
    if (w.held) continue;
    w.last_rate = w.watch != nullptr ? w.watch->rate(*world_).value_or(NAN) : speed(*w.side);
  }
}

// Slopes at both ends of the step from two short steps, at once for all conditions whose quantity provides no rate. False if the
// method failed.
bool Stops::find_slopes(Trial& trial, double end) {
  if (slopes_of_ == end) return true;
  const double bit = end / 64;
  const auto unknown = [](const Watched& w) { return w.watch != nullptr && !w.watch->start_rate; };
  if (!trial.see(bit)) return false;
  for (Watched& w : watched_)
    if (unknown(w)) w.rise = (excess(w) - w.watch->start) / bit;
  if (!trial.see(end - bit)) return false;
  for (Watched& w : watched_)
    if (unknown(w)) w.fall = (w.last - excess(w)) / bit;
  slopes_of_ = end;
  return true;
}

// The same from samples. A step of an adaptive method may be long where nothing moves although forces change: where bodies rest
// on a floor, or joints are locked. Each part of the step is halved until three values tell how the excess changes in it.
std::optional<double> Stops::search(Trial& trial, const Watched& w, const Part& part, int least_depth, int& samples) {
  const double middle = part.from + 0.5 * (part.to - part.from);
  if (!(middle > part.from && middle < part.to) || samples == 0) return -1;
  --samples;
  if (!trial.see(middle)) return std::nullopt;
  const double between = excess(w);
  if (between > 0) return middle;
  // A parabola rises above its highest value by at most an eighth of its second difference.
  const double bend = std::fabs(part.first - 2 * between + part.last), highest = std::max({part.first, between, part.last});
  if (!std::isfinite(bend) || (least_depth <= 0 && bend <= -2 * highest)) return -1;
  const std::optional<double> found = search(trial, w, {part.from, middle, part.first, between}, least_depth - 1, samples);
  if (!found || *found > 0) return found;
  return search(trial, w, {middle, part.to, between, part.last}, least_depth - 1, samples);
}

// A time at which the excess may have been positive although it is negative at both ends; −1: none.
std::optional<double> Stops::peak(Trial& trial, const Watched& w, double end) {
  const bool samples = trial.method.adaptive() && trial.method.dense();
  int most = most_samples;
  if (w.held) return samples ? search(trial, w, {0, end, w.q, w.last}, 0, most) : -1;
  if (w.side != nullptr) {
    if (!(w.v > 0 && w.last_rate < 0)) return -1;
    const Peak found = peak_between(end, w.q, w.v, w.last + w.limit, w.last_rate);
    return found.value < w.limit - 1e-2 * w.v * end ? -1 : found.time;
  }
  double rise = 0, fall = 0;
  if (w.watch->start_rate && std::isfinite(w.last_rate)) {
    rise = *w.watch->start_rate, fall = w.last_rate;
  } else {
    // The parabola through the last three values shows whether the excess may have risen and fallen in between. This is rare;
    // then, and in the first step after an event, slopes locate the peak.
    if (w.watch->ago > 0) {
      const double ahead = (w.last - w.watch->start) / end, behind = (w.watch->start - w.watch->before) / w.watch->ago;
      const double curvature = (ahead - behind) / (end + w.watch->ago),
                   slope = ahead - curvature * end;  // at the start of the step
      const double time = curvature < 0 ? std::clamp(-slope / (2 * curvature), 0.0, end) : 0;
      const double value = w.watch->start + time * (slope + curvature * time);
      const double least = -std::max(w.watch->start, w.last);
      if (samples && !(std::fabs(curvature) * end * end < least))
        return search(trial, w, {0, end, w.watch->start, w.last}, 2, most);
      if (curvature >= 0 || value < curvature * end * end) return -1;
    } else if (samples) {
      return search(trial, w, {0, end, w.watch->start, w.last}, 2, most);
    }
    if (!find_slopes(trial, end)) return std::nullopt;
    rise = w.rise, fall = w.fall;
  }
  if (!(rise > 0 && fall < 0) || !std::isfinite(rise) || !std::isfinite(fall)) return -1;
  const Peak found = peak_between(end, w.watch->start, rise, w.last, fall);
  if (!std::isfinite(found.time)) return -1;
  return found.value < -0.05 * (found.value - std::min(w.watch->start, w.last)) ? -1 : found.time;
}

// The first crossing in (0, end]; −1 if there is none; empty if the method failed.
std::optional<double> Stops::crossing(Trial& trial, const Watched& w, double end) {
  double outside = end, beyond = w.last;
  if (!(beyond > 0)) {  // beyond and back within the step?
    const std::optional<double> highest = peak(trial, w, end);
    if (!highest) return std::nullopt;
    if (!(*highest > 0)) return -1;  // no crossing; also where rates of rounding size give no time
    if (!trial.go(*highest)) return std::nullopt;
    outside = *highest, beyond = excess(w);
  }
  if (!(beyond > 0)) return -1;
  // The bracket cannot be narrower than the resolution of the clock.
  const double tolerance = std::max(tolerance_, 4 * std::numeric_limits<double>::epsilon() * end);
  const double within = w.held ? -beyond : w.start();
  Bracket between{0, within, outside, beyond};
  const auto value = [&](bool there) { return there ? std::optional(excess(w)) : std::nullopt; };
  std::optional<double> guess;
  Bracket about = between;
  if (trial.method.dense()) {
    if (!narrow(about, tolerance, {}, [&](double s) { return value(trial.see(s)); })) return std::nullopt;
    guess = about.outside;
  } else if (const auto [rise, fall] = w.rates(); outside == end && std::isfinite(rise + fall)) {
    const auto cubic = [&](double s) { return std::optional(cubic_between(end, within, rise, beyond, fall, s)); };
    if (narrow(about, tolerance, {}, cubic)) guess = about.outside;  // saves half of the trial steps of a falling body
  }
  if (!narrow(between, tolerance, guess, [&](double s) { return value(trial.go(s)); })) return std::nullopt;
  const bool precise = w.side != nullptr ? !w.held : w.watch->precise;
  if (!precise) return between.outside;
  // One Newton step: the joint then is at the stop to within rounding, however fast it moves.
  if (trial.at != between.outside && !trial.go(between.outside)) return std::nullopt;
  const double rate = w.side != nullptr ? speed(*w.side) : w.watch->rate(*world_).value_or(NAN);
  const double at = between.outside - excess(w) / rate;
  // The inner end may be the crossing to within rounding: then the Newton step ends just before it.
  return at > std::max(0.0, between.inside - tolerance) && at < between.outside ? at : between.outside;
}

// Puts a joint that hit a stop exactly onto it. All flights then begin and end at the same position: if each impact were slightly
// deeper than the previous one, bounces would gain the corresponding energy, and the smallest ones would never end.
void Stops::put_on_stop(const Watched& w) {
  const Side& s = *w.side;
  const double limit = s.sign * w.limit;
  if (coordinate(s) == limit || std::fabs(coordinate(s) - limit) > 1e-9 * (1 + std::fabs(limit))) return;
  const Tree& tree = world_->tree();
  if (is_loop({s.joint})) {  // by a small motion that keeps the loops closed
    (*evaluate_)(state());
    int place = 0;
    while (tree.loops()[static_cast<std::size_t>(place)].id().index != s.joint) ++place;
    double* const u = workspace().impulse.get();
    const double missing = limit - coordinate(s);
    const double unit = strike_loop(tree, state().q().data(), workspace(), place, s.dof, u);
    const State::Edit edit = state().edit();
    detail::displace(tree, u, missing / unit, edit.q.data());
    return;
  }
  state().edit().q[static_cast<std::size_t>(tree.first_q(tree.carrier(s.joint)) + s.dof)] = limit;
}

// A joint that is at the stop, not moving away: rounding must not make this an impact.
bool Stops::touches(const Side& s) const { return at_stop(s) && speed(s) >= -no_speed * s.rest_speed; }

std::optional<double> Stops::step(Integrator& method, EnergyLedger& ledger, double h, std::span<const Watch> watches) {
  (*evaluate_)(state());
  watched_.clear();
  bool holding = false;
  for (Side& s : sides_) {
    if ((locked(s) && !holds(s)) || is_stepped(s)) continue;
    // A joint that is at the stop or beyond it at the start moves away from there: only its return counts.
    const double q = s.sign * coordinate(s);
    if (q < s.sign * s.limit) s.edge = -HUGE_VAL;
    const double limit = std::max(edge(s), q) + (touches(s) ? rounding(s) + 1e-13 * (1 + std::fabs(s.limit)) : 0.0);
    watched_.push_back({&s, nullptr, limit, q, speed(s), holds(s)});
    holding = holding || holds(s);
  }
  if (holding && method.adaptive() && method.dense()) {
    accelerate(world_->tree(), state(), workspace());
    for (Watched& w : watched_)
      if (w.held) w.q = pull(*w.side);
  }
  for (const Watch& watch : watches) watched_.push_back({nullptr, &watch});
  start_ = state();
  Trial trial{*world_, *evaluate_, method, ledger, start_, ledger, holding, 0, 0, end_};
  method.note_start();
  bool fine = trial.first(h);
  double end = trial.at;
  const Watched* first = nullptr;
  if (fine) look_at_end(0);
  slopes_of_ = 0;
  // The step ends at the first crossing. The likely one is located first: hundreds may lie in a step.
  const auto likely = std::ranges::max_element(watched_, {}, [](const Watched& w) {
    return w.last > 0 ? w.last / (w.last - (w.held ? -w.last : w.start())) : 0;  // part of the step that is beyond the secant
  });
  if (likely != watched_.end()) std::iter_swap(watched_.begin(), likely);
  for (std::size_t i = 0; fine && i < watched_.size(); ++i) {
    const std::optional<double> found = crossing(trial, watched_[i], end);
    fine = found.has_value();
    if (!fine || !(*found > 0)) continue;
    end = *found, first = &watched_[i];  // the step ends here for all remaining ones
    fine = trial.at == end || trial.go(end);
    if (fine) look_at_end(i + 1);
  }
  if (fine && trial.at != end) fine = trial.go(end);
  if (fine && first != nullptr && first->side != nullptr && !first->held) put_on_stop(*first);
  trial.done = fine;
  return fine ? std::optional(end) : std::nullopt;
}

}  // namespace momentree
