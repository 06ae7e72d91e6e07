#include <momentree/simulate/failure.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/loops/islands.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/integrate/stiffness.hpp>
#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/singular_start.hpp>

namespace momentree {

using detail::text;

namespace {

std::string joint_text(const World& world, int carrier) {
  return "joint '" + std::string(world.joint_name({world.tree().joint_of(carrier)})) + "'";
}

// Events within this time, or within a step if that is shorter, are counted (s).
constexpr double flood_time = 1e-3;
constexpr std::size_t most_events = 10'000, most_events_of_source = 100;

// The time that the last `count` events took.
double time_of_last(std::span<const Event> events, std::size_t count, double now) {
  return events.size() < count ? HUGE_VAL : now - events[events.size() - count].time;
}

// What to do about events like these.
const char* cure(const Event& last) {
  const bool at_stop = !last.actions.empty() && (last.actions.front().kind == "hit" || last.actions.front().kind == "rest" ||
                                                 last.actions.front().kind == "leave");
  if (at_stop) return "give the joint's limits less restitution or a larger rest_speed, or move the stop";
  if (!last.contact.cable.empty()) return "give the cable less restitution, or replace it by a stiff spring";
  if (!last.contact.one.empty()) return "give the contacts less restitution, or use the method stepping";
  return "do they trigger each other? Give those that follow others a delay";
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

std::string link_text(const World& world, std::size_t link) {
  const Tree& tree = world.tree();
  const auto name = [&](JointId joint) { return std::string(world.joint_name(joint)); };
  if (link < tree.loops().size()) return "loop '" + name(tree.loops()[link].id()) + "'";
  const Coupling& coupling = tree.couplings()[static_cast<std::size_t>(tree.loops().links[link].ends.coupling)];
  return "the coupling of " + coupling_text(coupling, name(coupling.joint), coupling.leads() ? name(coupling.follows) : "");
}

// The joints with prescribed motions that move together with a body.
std::string driven_joints_text(const World& world, int body) {
  const Tree& tree = world.tree();
  const Islands islands(tree);
  std::string names;
  const auto add = [&](int end, JointId joint) {
    if (islands.of(end) == islands.of(body)) names += (names.empty() ? "'" : ", '") + std::string(world.joint_name(joint)) + "'";
  };
  for (const int b : tree.joints_with().motions) add(b, {tree.joint_of(b)});
  for (const Loop& loop : tree.loops())
    if (loop.driven()) add(loop.body >= 0 ? loop.body : loop.to, loop.id());
  return names;
}

// What cannot be closed any more within `longest` seconds from now because of prescribed motions; empty: nothing.
std::string out_of_reach(const World& world, double h, double longest) {
  const Tree& tree = world.tree();
  for (double later = h; later > 0 && later <= longest; later *= 10) {
    std::vector<double> q(world.state().q().begin(), world.state().q().end()), u(static_cast<std::size_t>(tree.nv())),
        open(tree.loops().links.size());
    const double t = world.time() + later;
    follow_motions(tree, t, q.data(), u.data());
    Workspace<double> workspace(tree);
    load_turns(tree, world.state(), workspace);
    if (assemble_loops(tree, t, q.data(), u.data(), workspace, open.data())) continue;
    const auto link = static_cast<std::size_t>(std::max_element(open.begin(), open.end()) - open.begin());
    const bool loop = link < tree.loops().size();
    const int body = !loop                          ? tree.loops().links[link].ends.joint
                     : tree.loops()[link].body >= 0 ? tree.loops()[link].body
                                                    : tree.loops()[link].to;
    const std::string joints = driven_joints_text(world, body);
    if (joints.empty()) return {};
    const bool several = joints.find(',') != std::string::npos;
    return link_text(world, link) + (loop ? " can't be closed" : " can't hold") + " any more: the prescribed motion" +
           (several ? "s of joints " : " of joint ") + joints + (several ? " lead" : " leads") +
           " out of the reach of the mechanism; keep the motion within reach, or end the run before";
  }
  return {};
}

// The loops in whose singular position the run ended, or all.
std::string open_loops(const World& world) {
  const std::vector<JointId> singular = singular_loops(world);
  if (singular.empty()) return "the loops";
  std::string names;
  for (const JointId loop : singular) names += (names.empty() ? "'" : ", '") + std::string(world.joint_name(loop)) + "'";
  return "near a singular position, loop " + names;
}

std::string what_diverged(const World& world, const Integrator& method, double h) {
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
  if (method.loops_open()) return open_loops(world) + " can't be closed" + (method.adaptive() ? " after any step" : within);
  const std::string what = method.adaptive() ? "no step is short enough" : "a step of " + text(h) + " s could not be solved";
  if (fastest < 0 || speed == 0) return what;
  return what + "; " + joint_text(world, fastest) + " is the fastest, at " + text(speed) + " rad/s or m/s";
}

// Point masses in a straight line, such as the links of a stretched chain, turn about it without moving any mass.
std::string cure_of_point_masses(const World& world) {
  if (!world.model().has_contact()) return {};  // which stretches and folds them
  for (const int b : world.tree().order()) {
    const BodySpec& body = world.model()[BodyId{b}];
    const Sym3& J = body.inertia;
    if (body.mass > 0 && J.xx + J.yy + J.zz == 0 && info(world.tree().kind(b)).nv > 0)
      return ", or an inertia for bodies that have none, such as '" + body.name +
             "': point masses in a straight line turn about it without moving any mass";
  }
  return {};
}

}  // namespace

std::string divergence_text(const World& world, const Integrator& method, const Integration& integration, double h) {
  const std::string when = "diverged at t = " + text(world.time()) + " s: ";
  if (const auto stiff = too_stiff(world.tree(), world.state().q(), integration.method, h))
    return when + stiff->what(world.joint_name({stiff->joint}), h) + "; " + stiff->cure();
  if (const auto stiff = too_stiff_spring(world.tree(), world.state().q(), integration.method, h))
    return when + stiff->what(world.spring({stiff->spring}).name, h) + "; " + stiff->cure();
  if (method.loops_open() || (method.adaptive() && world.tree().has_loops()))
    if (const std::string what = out_of_reach(world, h, std::max(h, 10 * integration.step)); !what.empty()) return when + what;
  return when + what_diverged(world, method, h) + "; use " +
         (method.adaptive() ? "larger tolerances rtol and atol"
                            : "a smaller step, such as " + text(integration.step / 4) + " s") +
         ", or more damping or inertia at that joint" + cure_of_point_masses(world);
}

std::string no_progress_at(double time) { return "no progress at t = " + text(time) + " s: "; }

std::string last_events(std::span<const Event> events) {
  const auto one = [](const Event& e) {
    const bool of_bodies = !e.contact.one.empty() && e.contact.cable.empty();
    return "'" + e.name + (e.actions.empty() ? "" : ": " + e.actions.front().text()) +
           (of_bodies ? " " + e.contact.one + ", " + e.contact.other : "") + "'";
  };
  if (events.empty()) return "none";
  return one(events.back()) + (events.size() > 1 ? " and " + one(events[events.size() - 2]) : "");
}

bool may_be_flood(std::span<const Event> events, double now, double step) {
  return time_of_last(events, most_events, now) < std::min(step, flood_time);
}

std::optional<std::string> flood_text(std::span<const Event> events, double now, double step, const EventSources& from) {
  const double within = std::min(step, flood_time);
  const std::size_t most =
      most_events + most_events_of_source * from.sources + static_cast<std::size_t>(std::min(1e15, from.repeated * within));
  const double took = time_of_last(events, most, now);
  if (!(took < within)) return std::nullopt;
  const auto mends = [](const Event& event) { return !event.stepped.empty(); };  // contacts are stepped through from then on
  if (std::ranges::any_of(events.last(most), mends)) return std::nullopt;
  return no_progress_at(now) + "events follow each other endlessly: " + std::to_string(most) + " of them took " + text(took) +
         " s, the last ones " + last_events(events) + "; " + cure(events.back());
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
  constexpr double most_to_come = 1e8;
  const bool busy = std::isfinite(until) && happened > static_cast<std::size_t>(steps) / 4 &&
                    left / steps * static_cast<double>(happened) > most_to_come;
  if (gone > 0 && !lost && !busy) return std::nullopt;
  const std::string what = no_progress_at(world.time()) + "the last " + std::to_string(steps_between_looks) +
                           " steps advanced the clock by no more than " + text(gone) + " s; ";
  if (happened > static_cast<std::size_t>(steps) / 4)
    return what + "events follow each other endlessly, the last ones " + last_events(events) + "; " + cure(events.back());
  if (method.adaptive())
    return what + "the tolerances are below the rounding errors of the motion: use larger rtol and atol, or a fixed step";
  return what + "the step of " + text(integration.step) + " s is too short for a run of " + text(until) + " s";
}

}  // namespace momentree
