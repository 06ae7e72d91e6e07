// The world as packed arrays: values of all joints at once, and the equations of motion.
#include <cmath>

#include <momentree/base/error.hpp>
#include <momentree/dynamics/equations.hpp>
#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/assembly.hpp>
#include <momentree/simulate/world/world.hpp>
#include <momentree/tree/edit.hpp>
#include <momentree/tree/packed.hpp>

namespace momentree {

namespace {
std::size_t count(int n) { return static_cast<std::size_t>(n); }
}  // namespace

Numbers World::v() const {
  evaluate();
  return {workspace_.v.get(), count(tree_.nv())};
}
Numbers World::qdot() const {
  evaluate();
  return {workspace_.qdot.get(), count(tree_.nq())};
}
Numbers World::p() const {
  evaluate();
  if (state_.variables() == Variables::momenta) return state_.p();
  return {workspace_.p.get(), count(tree_.nv())};
}
Numbers World::pdot() const {
  evaluate();
  const bool momenta = state_.variables() == Variables::momenta;
  if (!momenta || tree_.has_loops()) find_momentum_rates(tree_, state_, workspace_);
  if (momenta && tree_.has_loops()) return {workspace_.p.get(), count(tree_.nv())};
  return {workspace_.pdot.get(), count(tree_.nv())};
}
Numbers World::a() const {
  accelerate(tree_, state_, workspace_);
  return {workspace_.a.get(), count(tree_.nv())};
}

void WorldEquations::point_jacobian(BodyId body, Vec3 point, double* J) const {
  momentree::point_jacobian(tree_, state_, workspace_, body, point, J);
}

// `rates`: velocities or momenta.
bool World::stays_resting(const ActiveLimit& limit, std::span<const double> q, std::span<const double> rates) const {
  if (is_loop({limit.joint})) return std::equal(q.begin(), q.end(), state_.q().begin());
  const int b = tree_.carrier(limit.joint);
  const std::size_t at = count(tree_.first_q(b) + limit.dof);
  return q[at] == state_.q()[at] && rates[count(tree_.first_p(b) + limit.dof)] == 0;
}

std::vector<double> World::momenta_of(std::span<const double> q, std::span<const double> v, std::optional<double> time) const {
  const JointNamer name = [this](int joint) { return names_.joint(joint); };
  const double at = time.value_or(this->time());
  if (!std::isfinite(at)) throw_error({"the time can't be " + detail::text(at) + " s", "", ""});
  check_packed(tree_, "coordinates", true, q, name);
  check_packed(tree_, "velocities", false, v, name);
  std::vector<double> coordinates(q.begin(), q.end()), rates(v.begin(), v.end()), p(v.size());
  normalise_quaternions(tree_, coordinates, name);
  std::vector<std::pair<std::size_t, double>> released;  // DoFs that no longer rest on a stop, with their velocities
  for (const ActiveLimit& h : constraints_.active_limits)
    if (!is_loop({h.joint}) && !stays_resting(h, coordinates, rates)) {
      const std::size_t i = count(tree_.first_p(tree_.carrier(h.joint)) + h.dof);
      released.emplace_back(i, rates[i]);
    }
  clear_locked(tree_, rates.data());
  for (const auto& [i, rate] : released) rates[i] = rate;
  follow_motions(tree_, at, coordinates.data(), rates.data());
  project_momentum(tree_, coordinates.data(), rates.data(), p.data());
  for (auto& [i, kept] : released) kept = p[i];
  clear_locked(tree_, p.data());
  for (const auto& [i, kept] : released) p[i] = kept;
  return p;
}

// Throws Error, with nothing changed.
void World::set_values(double time, std::span<const double> q, std::span<const double> y, Variables given) {
  if (given == Variables::velocities && state_.variables() == Variables::momenta)
    return set_values(time, q, momenta_of(q, y, std::isfinite(time) && time >= 0 ? time : this->time()), Variables::momenta);
  const JointNamer name = [this](int joint) { return names_.joint(joint); };
  if (!(time >= 0) || !std::isfinite(time))
    throw_error({"the time can't be " + detail::text(time) + " s", "", "give a finite time that is not negative"});
  check_packed(tree_, "coordinates", true, q, name);
  check_packed(tree_, given == Variables::momenta ? "momenta" : "velocities", false, y, name);
  check_limits(tree_, q, name);
  std::vector<double> coordinates(q.begin(), q.end()), rates(y.begin(), y.end());
  normalise_quaternions(tree_, coordinates, name);
  std::optional<WorldSnapshot> before;  // loops may stay open
  if (tree_.has_loops()) before = snapshot();
  std::erase_if(constraints_.active_limits, [&](const ActiveLimit& h) {
    if (stays_resting(h, coordinates, rates)) return false;
    if (const Loop* const loop = is_loop({h.joint}) ? tree_.loops().find({h.joint}) : nullptr) {
      const Loop held = *loop;
      Joint joint = held.joint;
      joint.locked &= ~(1u << h.dof);
      tree_.edit().set_loop(held.number, joint, held.parameters, held.held);
      return true;
    }
    const int b = tree_.carrier(h.joint);
    Joint joint = tree_.joint(b);
    joint.locked &= ~(1u << h.dof);
    tree_.edit().set_joint(b, joint);
    return true;
  });
  clear_locked(tree_, rates.data());
  follow_motions(tree_, time, coordinates.data(), rates.data());
  assign(time, coordinates, rates, given);
  if (tree_.has_loops())
    if (std::optional<Error> error = assemble(tree_, model_, names_, state_)) {
      restore(*before);
      throw_error(std::move(*error));
    }
}

// Sets a state in velocities, or one in momenta from momenta.
void World::assign(double time, std::span<const double> q, std::span<const double> y, Variables given) {
  if (!tree_.contacts().empty()) tree_.edit().set_contacts({});  // the next run finds those of the new coordinates
  if (given == state_.variables()) return state_.assign(time, q, y, tree_);
  State momenta(tree_);
  momenta.assign(time, q, y, tree_);
  forward_dynamics(tree_, momenta, workspace_);
  state_.assign(time, q, {workspace_.v.get(), y.size()}, tree_);
}

// The same motion in other variables.
void World::take_variables(Variables variables) {
  if (state_.variables() == variables) return;
  evaluate();
  if (variables == Variables::velocities) return state_.change_variables(variables, v());
  std::vector<double> coordinates(state_.q().begin(), state_.q().end()), y(p().begin(), p().end());
  follow_motions(tree_, time(), coordinates.data(), y.data());
  state_.change_variables(variables, y);
}

}  // namespace momentree
