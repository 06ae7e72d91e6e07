// The equations of motion as matrices: against the oracle for random trees as declared, and for any topology against momenta,
// accelerations, motions and rates of the recursions, which share no code with them.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/dynamics/equations.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/tree/edit.hpp>
#include <tests/oracle/kinematics.hpp>
#include <tests/oracle/machine.hpp>
#include <tests/oracle/rearrange.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

struct Equations {
  Matrix M;
  Vector c, tau, v, a;
};
Equations equations(Machine& m) {
  const int n = m.tree.nv();
  // Wrong unless all numbers are written.
  Equations e{Matrix::Constant(n, n, NAN), Vector::Constant(n, NAN), Vector::Constant(n, NAN), {}, {}};
  mass_matrix(m.tree, m.state, m.workspace, e.M.data());
  bias(m.tree, m.state, m.workspace, e.c.data());
  efforts(m.tree, m.state, m.workspace, e.tau.data());
  accelerate(m.tree, m.state, m.workspace);
  e.v = Eigen::Map<const Vector>(m.workspace.v.get(), n);
  e.a = Eigen::Map<const Vector>(m.workspace.a.get(), n);
  return e;
}

Vector some(Prng& random, int n) {
  Vector x(n);
  for (double& each : x) each = random.uniform(-1, 1);
  return x;
}

// Calls f(body, DoF, index in packed arrays) for all DoFs.
template <class F>
void each_dof(const Tree& tree, F&& f) {
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i) f(b, i, tree.first_p(b) + i);
}
bool locked(const Tree& tree, int b, int i) { return (tree.joint(b).locked >> i & 1u) != 0; }
bool driven(const Tree& tree, int b) {
  return std::find(tree.joints_with().motions.begin(), tree.joints_with().motions.end(), b) != tree.joints_with().motions.end();
}

// Forces on some bodies and prescribed motions of some joints, at another time.
Model equipped(const Model& model, Prng& random) {
  Model out({.gravity = model.gravity()});
  for (BodySpec body : model.bodies()) {
    JointParameters& p = body.joint.parameters;
    if (info(body.joint.kind).nv == 1 && random.chance(0.2)) {
      p.effort = {}, p.limits = {};
      const double amplitude = random.uniform(0.1, 1), frequency = random.uniform(0.1, 1);
      p.drive = motion_drive(Signal::sine(amplitude, frequency, random.uniform(-3, 3)));
    }
    out.add_unjudged(body);
  }
  for (int b = 0; b < out.size(); ++b) {
    if (!random.chance(0.3)) continue;
    const Vec3 f = random.vector(10), t = random.vector(3), at = random.vector(0.5);
    out.add_force({.body = {b}, .point = at, .force = {f.x, f.y, f.z}, .torque = {t.x, t.y, t.z}, .drag = {.linear = 0.5}});
  }
  return out;
}

// A random tree in a random topology, with reversed, locked, driven and broken joints.
Machine rearranged(std::uint64_t seed, Prng& random) {
  RandomTreeOptions options;
  options.max_bodies = 20, options.drives = seed % 2 == 0, options.all_free = seed % 3 == 0;
  Machine m(equipped(random_tree(seed, options).model, random));
  for (int k = 0; k < 2; ++k) rearrange(random, m.tree, m.state, m.workspace);
  std::vector<double> v(static_cast<std::size_t>(m.tree.nv()));
  for (double& each : v) each = random.uniform(-1, 1);
  each_dof(m.tree, [&](int b, int i, int k) {
    if (locked(m.tree, b, i)) v[static_cast<std::size_t>(k)] = 0;
    if (driven(m.tree, b)) v[static_cast<std::size_t>(k)] = m.state.p()[static_cast<std::size_t>(k)];
  });
  std::vector<double> p(v.size());
  project_momentum(m.tree, m.state.q().data(), v.data(), p.data());
  each_dof(m.tree, [&](int b, int i, int k) {
    if (locked(m.tree, b, i)) p[static_cast<std::size_t>(k)] = 0;
  });
  {
    const State::Edit edit = m.state.edit();
    std::copy(p.begin(), p.end(), edit.p.begin());
  }
  m.evaluate();
  return m;
}

double largest(const Vector& x) { return x.size() == 0 ? 0 : x.cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("mass matrix, bias and Jacobians of random trees equal the oracle's") {
  double mass_error = 0, bias_error = 0, jacobian_error = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    const Model model = random_tree(seed, {.max_bodies = 25, .drives = seed % 2 == 0}).model;
    Machine m(model);
    const System system = system_of(model);
    const std::vector<double> q(m.state.q().begin(), m.state.q().end());
    const Equations e = equations(m);
    const MassMatrix M = oracle::mass_matrix(system, q);
    const int n = m.tree.nv();
    REQUIRE(M.size() == n);
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < n; ++k) {
        const double scale = static_cast<double>(std::sqrt(M(i, i) * M(k, k)));
        mass_error = std::max(mass_error, std::fabs(e.M(i, k) - static_cast<double>(M(i, k))) / scale);
        CHECK(e.M(i, k) == e.M(k, i));
      }
    const std::vector<Real> u(e.v.begin(), e.v.end());
    const std::vector<Real> a = accelerate(system, q, u, M).v, force = joint_forces(system, q, u), inertial = M.times(a);
    Real off = 0, size = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const Real c = force[i] - inertial[i];
      off = std::max(off, std::fabs(e.c[static_cast<Eigen::Index>(i)] - c));
      size = std::max({size, std::fabs(c), std::fabs(force[i]), std::fabs(inertial[i])});
      CHECK(std::fabs(e.tau[static_cast<Eigen::Index>(i)] - force[i]) <= 1e-12L * (1 + std::fabs(force[i])));
    }
    if (size > 0) bias_error = std::max(bias_error, static_cast<double>(off / size));
    if (n == 0 || seed % 5 != 0) continue;
    Prng random(seed);
    const int b = random.integer(0, model.size() - 1);
    const Vec3 point = random.vector(1);
    Matrix J = Matrix::Constant(6, n, NAN);
    point_jacobian(m.tree, m.state, m.workspace, {b}, point, J.data());
    for (int i = 0; i < n; ++i) {
      std::vector<Real> unit(static_cast<std::size_t>(n));
      unit[static_cast<std::size_t>(i)] = 1;
      const Evaluation::Motion motion = oracle::evaluate(system, q, unit, false).motions[static_cast<std::size_t>(b)];
      const V3<Real> linear = motion.velocity + cross(motion.angular, motion.frame.rotation * real(point));
      for (int row = 0; row < 3; ++row) {
        const auto k = static_cast<std::size_t>(row);
        jacobian_error = std::max(jacobian_error, std::fabs(J(row, i) - static_cast<double>(linear[k])));
        jacobian_error = std::max(jacobian_error, std::fabs(J(row + 3, i) - static_cast<double>(motion.angular[k])));
      }
    }
  }
  MESSAGE("largest errors: M ", mass_error, ", c ", bias_error, ", J ", jacobian_error);
  CHECK(mass_error < 1e-13);
  CHECK(bias_error < 1e-10);
  CHECK(jacobian_error < 1e-12);
}

TEST_CASE("M v are the momenta and M a + c the efforts in any topology; locked DoFs take no part") {
  double momentum_error = 0, effort_error = 0, inverse_error = 0;
  int locks = 0, drives = 0, reversed = 0, loaded = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    Prng random(seed + 5);
    Machine m = rearranged(seed, random);
    const int n = m.tree.nv();
    if (n == 0) continue;
    const Equations e = equations(m);
    const Vector Mv = e.M * e.v, inertial = e.M * e.a;
    const double momenta = largest(e.M.cwiseAbs() * e.v.cwiseAbs());
    const double size = std::max({largest(inertial), largest(e.c), largest(e.tau)});
    each_dof(m.tree, [&](int b, int i, int k) {
      reversed += m.tree.reversed(b) && i == 0;
      if (locked(m.tree, b, i)) {
        ++locks;
        CHECK(e.M.row(k).cwiseAbs().sum() == 1);
        CHECK(e.M.col(k).cwiseAbs().sum() == 1);
        CHECK(e.M(k, k) == 1);
        CHECK((e.c[k] == 0 && e.tau[k] == 0 && e.v[k] == 0 && e.a[k] == 0));
        return;
      }
      effort_error = std::max(effort_error, std::fabs(inertial[k] + e.c[k] - e.tau[k]) / size);
      if (driven(m.tree, b))
        ++drives;
      else if (momenta > 0)
        momentum_error = std::max(momentum_error, std::fabs(Mv[k] - m.state.p()[static_cast<std::size_t>(k)]) / momenta);
    });
    loaded += !m.tree.loads().bodies.empty();
    CHECK(e.M.ldlt().isPositive());
    Vector a = some(random, n), effort = Vector::Constant(n, NAN);
    inverse_dynamics(m.tree, m.state, m.workspace, a.data(), effort.data());
    each_dof(m.tree, [&](int b, int i, int k) {
      if (locked(m.tree, b, i)) a[k] = 0;
    });
    const Vector expected = e.M * a + e.c;
    inverse_error =
        std::max(inverse_error, largest(effort - expected) / std::max(largest(e.c), largest(e.M.cwiseAbs() * a.cwiseAbs())));
    inverse_dynamics(m.tree, m.state, m.workspace, a.data(), a.data());
    CHECK(a == effort);
  }
  MESSAGE("largest errors: p ", momentum_error, ", tau ", effort_error, ", inverse dynamics ", inverse_error, "; ", locks,
          " locked, ", drives, " driven, ", reversed, " reversed, ", loaded, " loaded");
  CHECK(momentum_error < 1e-10);
  CHECK(effort_error < 1e-10);
  CHECK(inverse_error < 1e-12);
  CHECK(locks > 500);
  CHECK(drives > 100);
  CHECK(reversed > 100);
  CHECK(loaded > 200);
}

TEST_CASE("M^-1 in any topology: of further right-hand sides, and as a matrix") {
  double residual = 0, identity = 0, momentum_error = 0;
  int held = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    Prng random(seed + 31);
    Machine m = rearranged(seed, random);
    const int n = m.tree.nv();
    if (n == 0) continue;
    const Equations e = equations(m);
    const auto is_held = [&](int b, int i) { return locked(m.tree, b, i) || driven(m.tree, b); };
    Vector r = some(random, n), u = Vector::Constant(n, NAN);
    Matrix inverse = Matrix::Constant(n, n, NAN);
    solve_mass(m.tree, m.state, m.workspace, r.data(), u.data());
    inverse_mass_matrix(m.tree, m.state, m.workspace, inverse.data());
    const Vector Mu = e.M * u;
    const Matrix product = e.M * inverse;
    const double size = std::max(largest(r), largest(e.M.cwiseAbs() * u.cwiseAbs()));
    each_dof(m.tree, [&](int b, int i, int k) {
      if (is_held(b, i)) {
        ++held;
        CHECK((u[k] == 0 && inverse.row(k) == Vector::Zero(n).transpose() && inverse.col(k) == Vector::Zero(n)));
        return;
      }
      residual = std::max(residual, std::fabs(Mu[k] - r[k]) / size);
      each_dof(m.tree, [&](int b2, int i2, int k2) {
        if (is_held(b2, i2)) return;
        const double scale = e.M.row(k).cwiseAbs().dot(inverse.col(k2).cwiseAbs());
        identity = std::max(identity, std::fabs(product(k, k2) - (k == k2 ? 1 : 0)) / std::max(scale, 1.0));
      });
    });
    // Velocities of the momenta, where no motion is prescribed.
    if (m.tree.joints_with().motions.empty()) {
      const Vector p = Eigen::Map<const Vector>(m.state.p().data(), n);
      solve_mass(m.tree, m.state, m.workspace, p.data(), u.data());
      momentum_error = std::max(momentum_error, largest(u - e.v) / std::max(1.0, largest(e.v)));
    }
    // In place, with the same bits.
    solve_mass(m.tree, m.state, m.workspace, r.data(), u.data());
    solve_mass(m.tree, m.state, m.workspace, r.data(), r.data());
    CHECK(r == u);
    CHECK(evaluated_on(m.tree, m.state, m.workspace));
  }
  MESSAGE("largest errors: residual ", residual, ", M M^-1 ", identity, ", velocities ", momentum_error, "; ", held, " held");
  CHECK(residual < 1e-11);
  CHECK(identity < 1e-10);
  CHECK(momentum_error < 1e-7);
  CHECK(held > 500);
}

TEST_CASE("columns of M are the momenta of single velocities, and of J the motions; J transposed makes forces of wrenches") {
  double mass_error = 0, motion_error = 0, force_error = 0, rate_error = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    CAPTURE(seed);
    Prng random(seed + 99);
    Machine m = rearranged(seed, random);
    const int n = m.tree.nv();
    const Equations e = equations(m);
    const BodyId body{random.integer(0, m.size() - 1)};
    const Vec3 point = random.vector(1);
    Matrix J = Matrix::Constant(6, n, NAN);
    point_jacobian(m.tree, m.state, m.workspace, body, point, J.data());

    Matrix none = Matrix::Constant(6, n, NAN);
    point_jacobian(m.tree, m.state, m.workspace, ground, point, none.data());
    CHECK(none == Matrix::Zero(6, n));

    m.evaluate();
    const Kinematics<double>& at = m.workspace.bodies[static_cast<std::size_t>(body.index)];
    const BodyMotion motion = user_motion(m.tree, at, body.index);
    const Vec3 linear = velocity_of(motion, point);
    const Vector Jv = J * e.v, expected{{linear.x, linear.y, linear.z, motion.angular.x, motion.angular.y, motion.angular.z}};
    motion_error = std::max(motion_error, largest(Jv - expected) / (1 + largest(J.cwiseAbs() * e.v.cwiseAbs())));

    each_dof(m.tree, [&](int b, int i, int k) {
      if (locked(m.tree, b, i)) {
        CHECK(J.col(k) == Vector::Zero(6));
        return;
      }
      Vector unit = Vector::Zero(n), column(n);
      unit[k] = 1;
      project_momentum(m.tree, m.state.q().data(), unit.data(), column.data());
      each_dof(m.tree, [&](int other, int j, int row) {
        if (locked(m.tree, other, j) || driven(m.tree, other)) return;
        mass_error = std::max(mass_error, std::fabs(column[row] - e.M(row, k)) / std::sqrt(e.M(row, row) * e.M(k, k)));
      });
    });

    const std::vector<double> pdot(m.workspace.pdot.get(), m.workspace.pdot.get() + n);
    const Vec3 force = random.vector(100), torque = random.vector(30);
    const Vec3 arm = rotation_matrix(motion.pose.rotation) * point;
    m.tree.edit().set_body_function(body.index, std::make_shared<const BodyFunction>([&](const EvaluationContext&) {
                                      return Wrench{force, torque + cross(arm, force)};
                                    }));
    m.state.replace(0, 0, {}, 0, 0, {}, m.tree);
    const Equations pushed = equations(m);
    const Vector generalised = J.transpose() * Vector{{force.x, force.y, force.z, torque.x, torque.y, torque.z}};
    const double size = std::max(largest(e.c), largest(generalised));
    if (n > 0 && size > 0) force_error = std::max(force_error, largest(e.c - pushed.c - generalised) / size);
    double rates = largest(generalised);
    for (const double x : pdot) rates = std::max(rates, std::fabs(x));
    each_dof(m.tree, [&](int b, int i, int k) {
      if (locked(m.tree, b, i) || driven(m.tree, b)) return;
      const auto at_k = static_cast<std::size_t>(k);
      rate_error = std::max(rate_error, std::fabs(m.workspace.pdot[at_k] - pdot[at_k] - generalised[k]) / rates);
    });
  }
  MESSAGE("largest errors: M ", mass_error, ", J v ", motion_error, ", c ", force_error, ", rates ", rate_error);
  CHECK(mass_error < 1e-13);
  CHECK(motion_error < 1e-12);
  CHECK(force_error < 1e-12);
  CHECK(rate_error < 1e-12);
}

TEST_CASE("the functions leave the results of an evaluation valid, and a World has them, too") {
  const Model model = random_tree(4, {.min_bodies = 12, .max_bodies = 20}).model;
  Simulation sim(model);
  const World& world = sim.world();
  Machine m(model);
  const Equations e = equations(m);
  const int n = m.tree.nv();
  REQUIRE(n > 5);
  const std::vector<BodyAcceleration> before = world.accelerations();
  const std::vector<double> pdot(world.pdot().begin(), world.pdot().end()), a(world.a().begin(), world.a().end());
  Matrix M(n, n), J(6, n), other(6, n);
  Vector c(n), tau(n), effort(n);
  for (int k = 0; k < 2; ++k) {
    world.equations().mass_matrix(M.data());
    world.equations().bias(c.data());
    world.equations().efforts(tau.data());
    world.equations().inverse_dynamics(e.a.data(), effort.data());
    world.equations().point_jacobian({7}, {1, 2, 3}, J.data());
  }
  CHECK(M == e.M);
  CHECK(c == e.c);
  CHECK(tau == e.tau);
  CHECK(largest(effort - tau) < 1e-10 * largest(tau.cwiseAbs() + c.cwiseAbs()));
  point_jacobian(m.tree, m.state, m.workspace, {7}, {1, 2, 3}, other.data());
  CHECK(J == other);
  CHECK(Eigen::Map<const Vector>(world.v().data(), n) == e.v);
  CHECK(std::equal(a.begin(), a.end(), world.a().begin()));
  CHECK(std::equal(a.begin(), a.end(), e.a.begin()));
  CHECK(std::equal(pdot.begin(), pdot.end(), world.pdot().begin()));
  CHECK(std::equal(world.qdot().begin(), world.qdot().end(), m.workspace.qdot.get()));
  CHECK(world.qdot().size() == static_cast<std::size_t>(m.tree.nq()));
  for (std::size_t b = 0; b < before.size(); ++b) CHECK(before[b].linear == world.accelerations()[b].linear);
  CHECK(reaction(m.tree, m.state, m.workspace, {3}).force == world.reaction({3}).force);
}
