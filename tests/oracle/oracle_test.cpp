// Tests of the oracle itself, against closed forms and against different derivations. Independent of the engine.
#include <cmath>

#include <doctest/doctest.h>

#include <tests/oracle/oracle.hpp>
#include <tests/oracle/random_model.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

struct Problem {
  System system;
  std::vector<double> q;
  std::vector<Real> v;
};
Problem problem(const Model& model) {
  const std::vector<double> v = start_v(model);
  return {system_of(model), start_q(model), {v.begin(), v.end()}};
}
JointSpec joint(Kind kind, Vec3 axis = {0, 0, 1}) {
  JointSpec spec;
  spec.kind = kind;
  spec.axis = axis;
  return spec;
}
Real largest(const std::vector<Real>& a) {
  Real most = 0;
  for (const Real x : a) most = std::max(most, std::fabs(x));
  return most;
}
Real difference(const std::vector<Real>& a, const std::vector<Real>& b) {
  std::vector<Real> d(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) d[i] = a[i] - b[i];
  return largest(d);
}

}  // namespace

TEST_CASE("oracle: a pendulum") {
  Model model;
  const double m = 2, l = 0.7, inertia = 0.05, angle = 0.6, speed = 1.3, rotor = 0.25;
  JointSpec hinge = joint(Kind::revolute, {0, 1, 0});
  hinge.parameters = {.damping = 0.3, .stiffness = 4, .rest = 0.1, .armature = rotor, .effort = 0.7};
  model.add({.name = "p",
             .mass = m,
             .com = {l, 0, 0},
             .inertia = diagonal(0.01, inertia, 0.04),
             .joint = hinge,
             .q = angle,
             .v = speed});
  const Problem s = problem(model);
  const MassMatrix mass = mass_matrix(s.system, s.q);
  CHECK(mass(0, 0) == doctest::Approx(m * l * l + inertia + rotor).epsilon(1e-15));
  const Evaluation e = evaluate(s.system, s.q, s.v);
  // A rotation about +y by `angle` takes x to (cos, 0, −sin): height −l·sin(angle).
  const double g = 9.81;
  CHECK(e.potential == doctest::Approx(-m * g * l * std::sin(angle) + 2 * 0.5 * 0.5).epsilon(1e-15));
  CHECK(e.kinetic == doctest::Approx(0.5 * (m * l * l + inertia + rotor) * speed * speed).epsilon(1e-15));
  CHECK(e.pdot[0] == doctest::Approx(m * g * l * std::cos(angle) + 0.7 - 0.3 * speed - 4 * 0.5).epsilon(1e-15));
  CHECK(e.linear[2] == doctest::Approx(-m * l * speed * std::cos(angle)).epsilon(1e-15));
  CHECK(e.angular[1] == doctest::Approx((m * l * l + inertia) * speed).epsilon(1e-15));
}

TEST_CASE("oracle: a double pendulum of point masses in absolute angles") {
  Model model({.gravity = {0, -9.81, 0}});
  const double a = 0.4, b = 1.1, w1 = 0.8, w2 = -1.7;  // absolute angles from +x and their rates; lengths and masses 1
  const BodyId first = model.add({.name = "1", .mass = 1, .com = {1, 0, 0}, .joint = joint(Kind::revolute), .q = a, .v = w1});
  model.add({.name = "2",
             .mass = 1,
             .com = {1, 0, 0},
             .parent = first,
             .at = {1, 0, 0},
             .joint = joint(Kind::revolute),
             .q = b - a,
             .v = w2 - w1});
  const Problem s = problem(model);
  const MassMatrix mass = mass_matrix(s.system, s.q);
  const double c = std::cos(b - a);
  CHECK(mass(0, 0) == doctest::Approx(3 + 2 * c).epsilon(1e-15));
  CHECK(mass(0, 1) == doctest::Approx(1 + c).epsilon(1e-15));
  CHECK(mass(1, 1) == doctest::Approx(1).epsilon(1e-15));
  const Evaluation e = evaluate(s.system, s.q, s.v);
  // L = w1² + w2²/2 + w1 w2 cos(b − a) − g(2 sin a + sin b) with b = q0 + q1.
  CHECK(e.kinetic == doctest::Approx(w1 * w1 + w2 * w2 / 2 + w1 * w2 * c).epsilon(1e-15));
  CHECK(e.pdot[0] == doctest::Approx(-9.81 * (2 * std::cos(a) + std::cos(b))).epsilon(1e-14));
  CHECK(e.pdot[1] == doctest::Approx(-w1 * w2 * std::sin(b - a) - 9.81 * std::cos(b)).epsilon(1e-14));
}

TEST_CASE("oracle: Euler's equations of a free body and of a ball") {
  for (const Kind kind : {Kind::ball, Kind::free}) {
    CAPTURE(static_cast<int>(kind));
    Prng random(7);
    Model model({.gravity = {0, 0, 0}});
    BodySpec body{.name = "b", .mass = 3, .inertia = diagonal(1, 2, 3), .joint = joint(kind)};
    body.q = random_coordinates(random, kind);
    body.v = random_velocities(random, kind);
    model.add(body);
    const Problem s = problem(model);
    const Evaluation e = evaluate(s.system, s.q, s.v);
    const std::size_t h = kind == Kind::free ? 3 : 0;
    const V3<Real> w{{s.v[h], s.v[h + 1], s.v[h + 2]}}, spin{{w[0], 2 * w[1], 3 * w[2]}};
    const V3<Real> torque = cross(spin, w);
    for (unsigned i = 0; i < 3; ++i) CHECK(e.pdot[h + i] == doctest::Approx(static_cast<double>(torque[i])).epsilon(1e-14));
    if (kind == Kind::ball) continue;
    const V3<Real> l{{3 * s.v[0], 3 * s.v[1], 3 * s.v[2]}}, force = cross(l, w);
    for (unsigned i = 0; i < 3; ++i) CHECK(e.pdot[i] == doctest::Approx(static_cast<double>(force[i])).epsilon(1e-14));
  }
}

TEST_CASE("oracle: the torque of a ball's spring is −k·log(rest⁻¹ q)") {
  Model model({.gravity = {0, 0, 0}});
  JointSpec ball = joint(Kind::ball);
  // Rotated by 1.1 rad about n from a rest attitude that is itself rotated by 0.4 rad about z.
  const Vec3 n{2.0 / 3, -1.0 / 3, 2.0 / 3};
  const Quat rest{std::cos(0.2), 0, 0, std::sin(0.2)};
  const Quat turn{std::cos(0.55), std::sin(0.55) * n.x, std::sin(0.55) * n.y, std::sin(0.55) * n.z};
  const Quat q = rest * turn;
  ball.parameters.stiffness = 3;
  ball.parameters.rest = {rest.w, rest.x, rest.y, rest.z};
  model.add({.name = "b", .mass = 1, .inertia = diagonal(1), .joint = ball, .q = {q.w, q.x, q.y, q.z}});
  const Problem s = problem(model);
  const std::vector<Real> force = joint_forces(s.system, s.q, s.v);
  CHECK(force[0] == doctest::Approx(-3 * 1.1 * n.x).epsilon(1e-14));
  CHECK(force[1] == doctest::Approx(-3 * 1.1 * n.y).epsilon(1e-14));
  CHECK(force[2] == doctest::Approx(-3 * 1.1 * n.z).epsilon(1e-14));
  CHECK(potential(s.system, s.q) == doctest::Approx(1.5 * 1.1 * 1.1).epsilon(1e-14));
}

TEST_CASE("oracle: Lagrange with Hamel's terms is d'Alembert without") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    const Problem s = problem(random_tree(seed, {.max_bodies = 20}).model);
    const Evaluation e = evaluate(s.system, s.q, s.v);
    CHECK(difference(e.pdot, e.pdot_alembert) <= 1e-15L * (1 + largest(e.pdot)));
  }
}

TEST_CASE("oracle: the mass matrix gives the kinetic energy, and solving undoes it") {
  for (std::uint64_t seed = 100; seed < 160; ++seed) {
    CAPTURE(seed);
    const Problem s = problem(random_tree(seed, {.max_bodies = 20}).model);
    const MassMatrix mass = mass_matrix(s.system, s.q);
    const std::vector<Real> p = mass.times(s.v);
    Real twice = 0;
    for (std::size_t i = 0; i < p.size(); ++i) twice += p[i] * s.v[i];
    const Evaluation e = evaluate(s.system, s.q, s.v, false);
    CHECK(std::fabs(twice / 2 - e.kinetic) <= 1e-17L * e.kinetic);
    if (s.v.empty()) continue;
    const Spectrum range = spectrum(mass);
    CHECK(difference(solve(mass, p), s.v) <= 1e-18L * range.condition());
  }
}

TEST_CASE("oracle: rates of energy and momenta along the motion, by differences") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    CAPTURE(seed);
    const Problem s =
        problem(random_tree(seed, {.max_bodies = 8, .several_mechanisms = false, .all_free = true, .conservative = true}).model);
    const std::vector<Real> p = mass_matrix(s.system, s.q).times(s.v);
    const Evaluation now = evaluate(s.system, s.q, s.v);
    const Real h = 1e-6L;
    Evaluation side[2];
    for (int i = 0; i < 2; ++i) {
      const Real dt = i ? h : -h;
      const std::vector<double> q = displaced(s.system, s.q, s.v, dt);
      std::vector<Real> moved = p;
      for (std::size_t k = 0; k < p.size(); ++k) moved[k] += dt * now.pdot[k];
      side[i] = evaluate(s.system, q, solve(mass_matrix(s.system, q), moved), false);
    }
    Real mass = 0;
    V3<Real> context{};
    for (std::size_t k = 0; k < now.motions.size(); ++k) {
      mass += s.system.links[k].mass;
      context = context + scaled(static_cast<Real>(s.system.links[k].mass), now.motions[k].com);
    }
    const V3<Real> torque = cross(context, s.system.gravity);
    const Real scale = 1 + now.kinetic + std::sqrt(dot(context, context)) + mass;
    // A spring or armature at the root joint acts on the ground: only energy is then conserved.
    const JointParameters& root = s.system.links[0].joint.parameters;
    const bool outside = root.stiffness.any() || root.armature.any();
    CHECK(std::fabs(side[1].kinetic + side[1].potential - side[0].kinetic - side[0].potential) / (2 * h) <= 1e-7L * scale);
    for (unsigned i = 0; i < 3 && !outside; ++i) {
      CHECK(std::fabs((side[1].linear[i] - side[0].linear[i]) / (2 * h) - mass * s.system.gravity[i]) <= 1e-7L * scale);
      CHECK(std::fabs((side[1].angular[i] - side[0].angular[i]) / (2 * h) - torque[i]) <= 1e-7L * scale);
    }
  }
}
