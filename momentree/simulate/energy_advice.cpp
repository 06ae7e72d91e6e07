// The warning about an energy balance that does not close.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/simulation_impl.hpp>
#include <momentree/simulate/stepping/overlap.hpp>

namespace momentree {

namespace {

// Beyond this fraction of the largest kinetic energy the computed motion is not trusted.
constexpr double tolerated = 1e-3;
constexpr double tolerances_closed = 100;    // relative tolerances of an adaptive method: what closing loops may add
constexpr double tolerated_overlaps = 5e-2;  // what removing them adds where contacts were stepped through
constexpr double rounding = 1e-12;           // of all energies that were turned over
// Where hardly anything moves, errors are compared with the energies that bodies get by falling their own size: coordinates are
// known to about the first fraction of it, and what rests on contacts that are stepped through falls a little in every step.
constexpr double at_rest = 1e-10, at_rest_in_steps = 1e-4;
constexpr double tolerated_residual = 1e-2;  // of the law of contact in a step: 1e-5 is what is aimed at where bodies move
constexpr double nothing = 1e-40;            // J: energies below are round-off, whatever the scale of the model

std::string formatted(const char* pattern, double a) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, pattern, a);
  return buffer;
}

// A fraction of an energy: "11 % of", "12 times".
std::string share_text(double share) {
  return share < 10 ? formatted("%.2g %% of", 100 * share) : formatted("%.0f times", share);
}

// How large an error of the balance is.
std::string size_of(double error, const EnergyBalance& balance) {
  std::string text = formatted("%.3g J", error) + ", ";
  if (std::fabs(error) < 1e3 * balance.largest_kinetic)
    return text + share_text(std::fabs(error) / balance.largest_kinetic) + " the largest kinetic energy";
  if (balance.of_heights > 0)
    return text + share_text(std::fabs(error) / balance.of_heights) +
           " the energy that the bodies would get by falling their own size";
  return text + "although nothing moves";
}

}  // namespace

std::string EnergyBalance::advice(const Integration& how) const {
  if (!std::isfinite(error) || !std::isfinite(initial) || !std::isfinite(final))
    return "the energies overflow: masses, lengths or speeds are too large";
  double turned_over = 0;  // its rounding is not an integration error
  for (const double part : {initial, final, work, dissipated, lost_in_impacts, released}) turned_over += std::fabs(part);
  const bool stepped = std::fabs(lost_in_steps) > rounding * turned_over;
  const double least = std::max({nothing, rounding * turned_over, (stepped ? at_rest_in_steps : at_rest) * of_heights});
  const auto too_much = [&](double energy, double part) {
    return !(std::fabs(energy) <= std::max(part * largest_kinetic, least));
  };
  const std::string step = "use a smaller step, such as " + formatted("%.3g s", how.step / 4),
                    tolerances = "use smaller tolerances, such as " + formatted("rtol = %.0e", how.rtol / 100);
  const bool adaptive = is_adaptive(how.method);
  if (stepped && too_much(projection, tolerated_overlaps))
    return "removing overlaps changed the energy by " + size_of(projection, *this) +
           ": contacts were stepped through with too long steps; " + step;
  if (too_much(error, tolerated)) {
    const std::string what = "the energy balance is off by " + size_of(error, *this) + ": the motion is not computed accurately";
    if (stepped) return what + ", because contacts were stepped through; " + step;
    if (adaptive) return what + "; " + tolerances;
    return what + "; " + step + (how.method == "damped" ? "" : ", or an adaptive method: dop853");
  }
  if (stepped || !too_much(projection, adaptive ? std::min(tolerated, tolerances_closed * how.rtol) : tolerated)) return {};
  return "closing loops and contacts after steps changed the energy by " + size_of(projection, *this) +
         ": steps are too long, or loops pass a position in which they are singular, such as a four-bar with all bars in line; " +
         (adaptive ? tolerances : step + ", or an adaptive method: dop853");
}

namespace {

// The first mechanism without a collision that has fallen below a plane of the ground; empty: none has.
std::string fell_through(const World& world) {
  const std::span<const Collider> colliders = world.model().colliders();
  const auto is_plane = [](const Collider& each) { return each.plane && each.body == ground; };
  if (std::ranges::none_of(colliders, is_plane)) return {};
  for (const Mechanism& mechanism : world.mechanisms()) {
    const auto is_part = [&](const Collider& each) {
      return std::ranges::find(mechanism.bodies, each.body) != mechanism.bodies.end();
    };
    if (mechanism.grounded || std::ranges::any_of(colliders, is_part)) continue;
    const auto root = static_cast<std::size_t>(mechanism.root.index);
    for (const Collider& plane : colliders)
      if (const double depth = dot(plane.point - world.motions()[root].pose.position, plane.normal); is_plane(plane) && depth > 0)
        return "'" + world.model().bodies()[root].name + "' has no collision and is " + formatted("%.3g", depth) +
               " m below the ground at the end; collision = \"shape\" lets its shape touch";
  }
  return {};
}

}  // namespace

std::vector<std::string> Simulation::warnings() const {
  std::vector<std::string> all = impl().stops.passed();
  const bool forced = !all.empty() && has_motions(impl_->world.tree());
  for (std::string& joint : all)
    joint = "at the end joint " + joint +
            ": a prescribed motion has forced this, or steps are too long; results since it began are not valid";
  if (std::string advice = energy().advice(integration()); !advice.empty() && !forced) all.push_back(std::move(advice));
  if (const RunStatistics& run = statistics(); run.contact_residual > tolerated_residual)
    all.push_back("at " + formatted("t = %.9g s", run.contact_residual_at) + " the impulses of contacts obey their law to " +
                  formatted("%.2g %%", 100 * run.contact_residual) + " only, of the speeds before; use a smaller step");
  for (const Event& event : events())
    if (event.name == passed_through)
      all.push_back("'" + event.contact.one + (event.contact.normal == Vec3{} ? "' passes through '" : "' passed through '") +
                    event.contact.other + (event.contact.normal == Vec3{} ? "' from " : "' at ") +
                    formatted("t = %.9g s", event.time) + ": " + event.reason);
  constexpr const char* why =
      ": a prescribed motion has forced this, or steps are too long; results since it began are not valid";
  const std::vector<KeptOverlap>& overlaps = impl().contact.stepping.overlaps;
  for (const KeptOverlap& kept : overlaps)
    all.push_back("from " + formatted("t = %.9g s", kept.since) + " on " + kept.deepest.text("up to ") + why);
  const auto is_left = [&](const Overlap& left) {
    return std::ranges::none_of(overlaps, [&](const KeptOverlap& kept) { return kept.deepest.same_pair(left); });
  };
  if (const std::optional<Overlap> left = momentree::overlap(*this); left && left->depth > left_by_steps && is_left(*left))
    all.push_back("at the end " + left->text() + why);
  if (std::string fallen = fell_through(impl_->world); !fallen.empty()) all.push_back(std::move(fallen));
  return all;
}

// Joints whose motion is prescribed.
std::string Simulation::Impl::moving_joints() const {
  std::string text;
  const auto add = [&](int joint) { text += (text.empty() ? "'" : ", '") + std::string(world.joint_name({joint})) + "'"; };
  for (const int b : world.tree().joints_with().motions) add(world.tree().joint_of(b));
  for (const Loop& loop : world.tree().loops())
    if (loop.parameters.drive != nullptr && loop.parameters.drive->moves()) add(loop.id().index);
  return text;
}

void Simulation::Impl::report_blocked_stop() {
  outcome.message = no_progress_at(world.time()) + "joint '" + std::string(world.joint_name({stops.blocked()})) +
                    "' can't be stopped at its limit: nothing that moves it can give way; ";
  outcome.message += has_motions(world.tree())
                         ? "the motion of " + moving_joints() + " is prescribed: leave the 'limits' out, make them soft by a " +
                               "'stiffness', or drive by 'pd'"
                         : "leave its 'limits' out, or make them soft by a 'stiffness'";
  outcome.stalled = true;
}

void Simulation::Impl::report_pressing(double gained) {
  outcome.message =
      no_progress_at(world.time()) + "the prescribed motion of " + moving_joints() +
      " presses bodies against others, or joints on their stops, that can't give way: contacts changed the energy by " +
      detail::text(gained) + " J in a step; let the motion end before, or drive by 'pd'";
  outcome.stalled = true;
}

// What a step through contacts may change the energy by at most is of the order of this (J).
double Simulation::Impl::energy_scale() {
  double mass = 0;
  for (const int b : world.tree().order()) mass += world.tree().link(b).body.m;
  const double fastest = contact.geometry.stepped.fastest() + norm(world.model().gravity()) * integration.step;
  return energy.balance.largest_kinetic + std::fabs(energy.balance.initial) +
         std::fabs(energy.ledger.work - energy.ledger.impacts) + mass * fastest * fastest + energy_of_heights(world);
}

double energy_of_heights(const World& world) {
  const Tree& tree = world.tree();
  std::vector<double> size(static_cast<std::size_t>(tree.bodies()), 0.0);
  for (const Collider& collider : world.model().colliders())
    if (!collider.plane && collider.body != ground && world.alive(collider.body)) {
      double& own = size[static_cast<std::size_t>(collider.body.index)];
      own = std::max(own, collider.solid.reach);
    }
  double sum = 0;
  for (const int b : tree.order()) {
    const RigidMass& mass = tree.link(b).body;
    if (!(mass.m > 0)) continue;
    const double gyration = std::sqrt(std::max(0.0, mass.J.xx + mass.J.yy + mass.J.zz) / (2 * mass.m));
    sum += mass.m * std::max(size[static_cast<std::size_t>(b)], gyration);
  }
  return norm(world.model().gravity()) * sum;
}

}  // namespace momentree
