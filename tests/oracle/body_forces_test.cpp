// Forces on bodies, including drag, on random trees: rates from the Jacobian of the oracle's own kinematics, accelerations from
// the oracle's mass matrix, equations of motion of every body after any changes, balances of momentum and energy.
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <tests/oracle/kinematics.hpp>
#include <tests/oracle/laws.hpp>
#include <tests/oracle/machine.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

Vec3 some_vector(Prng& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}
std::array<Signal, 3> some_signals(Prng& random, double size) {
  const Vec3 a = some_vector(random, size);
  const Signal changing =
      random.chance(0.5) ? Signal::sine(a.y, 0.7, 0.3, a.x) : Signal::table({{-1, a.x}, {0.4, a.y}, {2, a.z}});
  return {changing, Signal(a.y), Signal(a.z)};
}

// Two thirds of the bodies get forces, some of them several.
void load(Prng& random, Model& model) {
  for (int b = 0; b < model.size(); ++b)
    while (random.chance(0.4)) {
      BodyForce f{.body = {b}, .point = some_vector(random, 0.5), .force = some_signals(random, 20)};
      f.torque = some_signals(random, 5);
      f.body_axes = random.chance(0.5);
      if (random.chance(0.6)) f.drag = {random.uniform(0, 2), random.uniform(0, 3), random.uniform(0, 1)};
      model.add_force(f);
    }
}

// The forces on each body at a time, about its frame's origin in world axes, as documented.
std::vector<Load> loads_of(const Model& model, const std::vector<Evaluation::Motion>& motions, double t) {
  std::vector<Load> loads(static_cast<std::size_t>(model.size()));
  for (const BodyForce& f : model.forces()) {
    const auto b = static_cast<std::size_t>(f.body.index);
    const Evaluation::Motion& m = motions[b];
    const V3<Real> arm = m.frame.rotation * real(f.point), v = m.velocity + cross(m.angular, arm);
    const auto at = [t](const std::array<Signal, 3>& s) { return real(Vec3{s[0].value(t), s[1].value(t), s[2].value(t)}); };
    const auto world = [&](const V3<Real>& a) { return f.body_axes ? m.frame.rotation * a : a; };
    const Real speed = std::sqrt(dot(v, v));
    const V3<Real> force = world(at(f.force)) - scaled(f.drag.linear + f.drag.quadratic * f.drag.area * speed, v);
    loads[b].force = loads[b].force + force;
    loads[b].torque = loads[b].torque + world(at(f.torque)) + cross(arm, force);
  }
  return loads;
}

// Jᵀ W: the columns of the Jacobian are the body motions caused by single DoFs.
std::vector<Real> generalised(const System& system, const std::vector<double>& q, const std::vector<Load>& loads) {
  std::vector<Real> sum(static_cast<std::size_t>(system.nv()));
  for (std::size_t i = 0; i < sum.size(); ++i) {
    std::vector<Real> unit(sum.size());
    unit[i] = 1;
    const Evaluation e = evaluate(system, q, unit, false);
    for (std::size_t b = 0; b < loads.size(); ++b)
      sum[i] += dot(loads[b].force, e.motions[b].velocity) + dot(loads[b].torque, e.motions[b].angular);
  }
  return sum;
}

std::vector<Load> loads_now(Machine& m) {
  std::vector<Evaluation::Motion> motions(static_cast<std::size_t>(m.size()));
  m.evaluate();
  for (int b = 0; b < m.size(); ++b) {
    Evaluation::Motion& motion = motions[static_cast<std::size_t>(b)];
    const Kinematics<double>& k = m.workspace.bodies[static_cast<std::size_t>(b)];
    motion.frame = frame_of(m.pose(b));
    motion.angular = real(k.R * k.velocity.w);
    motion.velocity = real(k.R * k.velocity.v) + cross(motion.angular, motion.frame.position - real(k.r));
  }
  return loads_of(m.model, motions, m.state.time());
}

// A change of topology that neither adds nor removes bodies.
void change_something(Prng& random, Machine& m) {
  m.evaluate();
  const int b = random.integer(0, m.size() - 1), other = random.integer(0, m.size() - 1);
  const int nv = info(m.tree.joint(b).kind).nv;
  switch (random.integer(0, 5)) {
    case 0:
      if (can_break(m.tree, m.tree.inboard_joint({b}))) apply(Break{m.tree.inboard_joint({b})}, m.tree, m.state, m.workspace);
      break;
    case 1:
      if (nv > 0) apply(Lock{m.tree.inboard_joint({b}), some_dofs(random, nv)}, m.tree, m.state, m.workspace);
      break;
    case 2: apply(random_change(random, m, b), m.tree, m.state, m.workspace); break;
    case 3:
      if (root_of(m.tree, {other}).index != root_of(m.tree, {b}).index && floats(m.tree, {b}))
        apply(Join{{b}, {other}}, m.tree, m.state, m.workspace);
      break;
    default:
      if (floats(m.tree, {b})) apply(Reroot{{b}}, m.tree, m.state, m.workspace);
  }
}

}  // namespace

TEST_CASE("(20) forces on bodies add Jt W to the rates, and to the accelerations through the mass matrix") {
  double worst_rate = 0, worst_acceleration = 0;
  for (std::uint64_t seed = 0; seed < 250; ++seed) {
    CAPTURE(seed);
    Prng random(seed * 3 + 1);
    Model model = random_tree(seed, {.max_bodies = 14}).model;
    load(random, model);
    if (model.forces().empty()) continue;
    Machine m(model);
    m.state.edit().time = random.uniform(0, 1);
    m.evaluate();
    const System system = system_of(model);
    const std::vector<double> q(m.state.q().begin(), m.state.q().end());
    const std::vector<Real> v(m.workspace.v.get(), m.workspace.v.get() + m.tree.nv());
    const Evaluation e = evaluate(system, q, v);
    const std::vector<Real> given = generalised(system, q, loads_of(model, e.motions, m.state.time()));
    std::vector<Real> expected = e.pdot;
    for (std::size_t i = 0; i < expected.size(); ++i) expected[i] += given[i];
    if (expected.empty()) continue;
    const MassMatrix mass = mass_matrix(system, q);
    const double condition = spectrum(mass).condition();
    const double rate = static_cast<double>(distance({m.workspace.pdot.get(), m.workspace.pdot.get() + m.tree.nv()}, expected) /
                                            (norm(e.pdot) + norm(given)));
    CHECK(rate < std::max(1e-9, 1e-15 * condition));
    worst_rate = std::max(worst_rate, rate);
    momentree::accelerate(m.tree, m.state, m.workspace);
    std::vector<Real> exact = accelerate(system, q, v, mass).v;
    const std::vector<Real> more = solve(mass, given);
    const Real scale = norm(exact) + norm(more);
    for (std::size_t i = 0; i < exact.size(); ++i) exact[i] += more[i];
    const double off = static_cast<double>(distance({m.workspace.a.get(), m.workspace.a.get() + m.tree.nv()}, exact) / scale);
    CHECK(off < std::max(1e-10, 1e-15 * condition));
    worst_acceleration = std::max(worst_acceleration, off);
  }
  MESSAGE("largest error of dp/dt ", worst_rate, ", of accelerations ", worst_acceleration);
}

TEST_CASE("through breaks, locks, joins, changes and re-rooting forces stay with their bodies, and every body's equations hold") {
  double residual = 0;
  int reversed = 0, loaded = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    CAPTURE(seed);
    Prng random(seed * 17 + 5);
    RandomTreeOptions options;
    options.max_bodies = 12;
    options.all_free = seed % 2 == 0;
    Model model = random_tree(seed, options).model;
    load(random, model);
    Machine m(model);
    const System system = system_of(m.model);
    for (int action = 0; action < 8; ++action) {
      CAPTURE(action);
      change_something(random, m);
      const double off = equations_of_motion(system, m.tree, m.state, m.workspace, loads_now(m));
      CHECK(off < 1e-10);
      CHECK(work_of_reactions(m.tree, m.state, m.workspace) < 1e-12);
      residual = std::max(residual, off);
      for (int k = 0; k < m.size(); ++k) reversed += m.tree.reversed(k);
      loaded += static_cast<int>(m.tree.loads().bodies.size());
    }
  }
  MESSAGE("largest residual of Newton and Euler ", residual, "; ", reversed, " reversed joints, ", loaded, " loaded bodies");
  CHECK(reversed > 200);
  CHECK(loaded > 2000);
}

TEST_CASE("the momentum of free trees changes by the external forces, their energy by its power") {
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    CAPTURE(seed);
    Prng random(seed * 7 + 3);
    Model model = random_tree(seed, {.max_bodies = 10, .all_free = true, .parameters = false}).model;
    load(random, model);
    Machine m(model);
    m.evaluate();
    std::vector<double> qdot(m.workspace.qdot.get(), m.workspace.qdot.get() + m.tree.nq());
    std::vector<double> pdot(m.workspace.pdot.get(), m.workspace.pdot.get() + m.tree.nv());
    const Power power = m.workspace.power;
    const auto at = [&](double h) {
      State moved = m.state;
      for (std::size_t i = 0; i < qdot.size(); ++i) moved.edit().q[i] += h * qdot[i];
      for (std::size_t i = 0; i < pdot.size(); ++i) moved.edit().p[i] += h * pdot[i];
      Workspace<double> workspace(m.tree);
      return totals(m.tree, moved, workspace);
    };
    Vec3 force{}, torque{};
    double mass = 0;
    Vec3 first_moment{};
    const std::vector<Load> loads = loads_now(m);
    for (int b = 0; b < m.size(); ++b) {
      const Load& load = loads[static_cast<std::size_t>(b)];
      const auto narrow = [](const V3<Real>& a) {
        return Vec3{static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
      };
      force += narrow(load.force);
      torque += narrow(load.torque) + cross(m.pose(b).position, narrow(load.force));
      const BodySpec& spec = model[{b}];
      mass += spec.mass;
      first_moment += spec.mass * (m.pose(b).position + rotation_matrix(m.pose(b).rotation) * spec.com);
    }
    force += mass * model.gravity();
    torque += cross(first_moment, model.gravity());
    const double h = 1e-5;
    const Totals a = at(h), b = at(-h);
    const Vec3 linear = (0.5 / h) * (a.linear - b.linear), angular = (0.5 / h) * (a.angular - b.angular);
    const double energy = (a.kinetic + a.potential - b.kinetic - b.potential) / (2 * h);
    const Totals now = at(0);
    const double size = 1 + norm(force) + norm(torque) + now.kinetic + std::fabs(power.work) + power.dissipated;
    CHECK(norm(linear - force) < 1e-6 * size);
    CHECK(norm(angular - torque) < 1e-6 * size);
    CHECK(std::fabs(energy - (power.work - power.dissipated)) < 1e-6 * size);
  }
}
