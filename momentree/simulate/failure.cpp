#include <momentree/simulate/failure.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/integrate/stiffness.hpp>
#include <momentree/simulate/arguments.hpp>

namespace momentree {

using detail::text;

namespace {

std::string joint_text(const World& world, int carrier) {
  return "joint '" + std::string(world.joint_name({world.tree().joint_of(carrier)})) + "'";
}

// The child body of the joint with the largest velocity, and that velocity.
std::pair<int, double> fastest_joint(const World& world) {
  int fastest = -1;
  double most = 0;
  for (const int b : world.tree().order())
    for (const double v : world.joint({world.tree().joint_of(b)}).v)
      if (fastest < 0 || !(std::fabs(v) <= most)) most = std::fabs(v), fastest = b;
  return {fastest, most};
}

std::string what_ran_away(const World& world, const Integrator& method, double h) {
  const Tree& tree = world.tree();
  const std::string within = " within a step of " + text(h) + " s";
  if (const auto& away = method.runaway_coordinate()) {
    for (const int b : tree.order()) {
      const int place = away->coordinate - tree.first_q(b);
      if (place < 0 || place >= info(tree.kind(b)).nq) continue;
      if (!std::isfinite(away->moved)) return joint_text(world, b) + " overflowed" + within;
      return joint_text(world, b) + " would move by " + text(away->moved) + " rad or m" + within;
    }
  }
  const auto [fastest, speed] = fastest_joint(world);
  if (method.loops_open()) return "the loops can't be closed" + (method.adaptive() ? " after any step" : within);
  const std::string what = method.adaptive() ? "no step is short enough" : "a step of " + text(h) + " s could not be solved";
  if (fastest < 0 || speed == 0) return what;
  return what + "; " + joint_text(world, fastest) + " is the fastest, at " + text(speed) + " rad/s or m/s";
}

}  // namespace

std::string divergence_text(const World& world, const Integrator& method, const Integration& integration, double h) {
  const std::string when = "diverged at t = " + text(world.time()) + " s: ";
  if (const auto stiff = too_stiff(world.tree(), world.state().q(), integration.method, h))
    return when + stiff->what(world.joint_name({stiff->joint}), h) + "; " + stiff->cure();
  return when + what_ran_away(world, method, h) + "; use " +
         (method.adaptive() ? "larger tolerances rtol and atol"
                            : "a smaller step, such as " + text(integration.step / 4) + " s") +
         ", or more damping or inertia at that joint";
}

std::string no_progress_at(double time) { return "no progress at t = " + text(time) + " s: "; }

std::string last_events(std::span<const Event> events) {
  const auto one = [](const Event& e) { return "'" + e.name + (e.actions.empty() ? "" : ": " + e.actions.front().text()) + "'"; };
  if (events.empty()) return "none";
  return one(events.back()) + (events.size() > 1 ? " and " + one(events[events.size() - 2]) : "");
}

std::optional<std::string> ProgressMonitor::look(const World& world, const Integrator& method, const Integration& integration,
                                                 std::span<const Event> events, double until) {
  const double gone = world.time() - mark_.time, steps = steps_between_looks, left = (until - world.time()) / gone * steps;
  const std::size_t happened = events.size() - std::min(events.size(), mark_.events);
  begin(world.time(), events.size());
  // A fixed step is the user's choice, unless the run could not finish on any machine. Adaptive methods make tiny steps without
  // progress if their tolerances are below rounding errors.
  const double moved = fastest_joint(world).second * gone / steps;
  // A run to infinity is judged by its observers.
  const bool lost = std::isfinite(until) && (method.adaptive() ? left > 1e9 && moved < 1e-5 : left > 2e11);
  const bool busy = happened > static_cast<std::size_t>(steps) / 4 && (std::isfinite(until) ? left > 1e9 : gone / steps < 1e-9);
  if (gone > 0 && !lost && !busy) return std::nullopt;
  const std::string what = no_progress_at(world.time()) + "the last " + std::to_string(steps_between_looks) +
                           " steps advanced the clock by no more than " + text(gone) + "s;  ";
  if (happened > static_cast<std::size_t>(steps) / 4)
    return what + "events follow each other endlessly, the last of them " + last_events(events) + "; do they trigger each other?";
  if (method.adaptive())
    return what + "the tolerances are below the rounding errors of the motion: use larger rtol and atol, or a fixed step";
  return what + "the step of " + text(integration.step) + " s is too short for a run of " + text(until) + " s";
}

}  // namespace momentree
