// Derivatives of accelerations, against differences of high order of the accelerations themselves, for random trees with forces
// of all kinds in any topology.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/tangent/acceleration_tangent.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/tree/edit.hpp>
#include <tests/oracle/loop_ring.hpp>
#include <tests/oracle/machine.hpp>
#include <tests/oracle/rearrange.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

using Vector = Eigen::VectorXd;

Vector some(Prng& random, int n, double size) {
  Vector x(n);
  for (double& each : x) each = random.uniform(-size, size);
  return x;
}

// Forces on bodies, and springs between them.
Model equipped(const Model& model, Prng& random) {
  Model out({.gravity = model.gravity()});
  for (const BodySpec& body : model.bodies()) out.add_unjudged(body);
  for (int b = 0; b < out.size(); ++b) {
    if (random.chance(0.3)) {
      const Vec3 f = random.vector(10), t = random.vector(3), at = random.vector(0.5);
      out.add_force({.body = {b},
                     .point = at,
                     .force = {f.x, f.y, f.z},
                     .torque = {t.x, t.y, t.z},
                     .body_axes = random.chance(0.5),
                     .drag = {.linear = 0.5, .quadratic = 0.3, .area = 1}});
    }
    if (random.chance(0.3)) {
      const int other = random.chance(0.3) ? -1 : random.integer(0, out.size() - 1);
      if (other == b) continue;
      Spring spring{.name = "s" + std::to_string(b), .from = {{b}, random.vector(0.5)}, .to = {{other}, random.vector(2)}};
      spring.stiffness = 40, spring.damping = 3, spring.rest = random.uniform(0, 1), spring.tension_only = random.chance(0.3);
      out.add_spring(spring);
    }
  }
  return out;
}

/// The accelerations of a state that is moved and hastened by h along a direction.
struct Path {
  const Tree& tree;
  const State& from;
  Vector dq, dv;
  Vector at(double h) const {
    State state(tree, Variables::velocities);
    Workspace<double> workspace(tree);
    {
      const State::Edit edit = state.edit();
      std::copy(from.q().begin(), from.q().end(), edit.q.begin());
      const Vector step = h * dq;
      displace(tree, step.data(), edit.q.data());
      for (int i = 0; i < tree.nv(); ++i) edit.u[static_cast<std::size_t>(i)] = from.u()[static_cast<std::size_t>(i)] + h * dv[i];
    }
    accelerate(tree, state, workspace);
    return Eigen::Map<const Vector>(workspace.a.get(), tree.nv());
  }
  /// Of eighth order.
  Vector rate(double h) const {
    const double weights[] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
    Vector sum = Vector::Zero(tree.nv());
    for (int k = 1; k <= 4; ++k) sum += weights[k - 1] * (at(k * h) - at(-k * h));
    return sum / h;
  }
};

void forget_locked(const Tree& tree, Vector& d) {
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      if ((tree.joint(b).locked >> i & 1u) != 0) d[tree.first_p(b) + i] = 0;
}

}  // namespace

TEST_CASE("derivatives of accelerations of random trees, in any topology, are those of their differences") {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    Prng random(seed);
    RandomTreeOptions options;
    options.max_bodies = 12, options.drives = seed % 2 == 0, options.all_free = seed % 3 == 0;
    const Model model = equipped(random_tree(seed, options).model, random);
    Machine m(model);
    for (int k = 0; k < static_cast<int>(seed % 5); ++k) act(random, m);
    State state(m.tree, Variables::velocities);
    {
      const State::Edit edit = state.edit();
      std::copy(m.state.q().begin(), m.state.q().end(), edit.q.begin());
      std::copy_n(m.workspace.v.get(), m.tree.nv(), edit.u.begin());
    }
    const int nv = m.tree.nv(), count = 1 + random.integer(0, 5);
    if (nv == 0) continue;
    Workspace<double> workspace(m.tree);
    accelerate(m.tree, state, workspace);
    if (not_differentiable(m.tree, workspace).part != NotDifferentiable::Part::none) continue;
    AccelerationTangent tangent(m.tree);
    tangent.prepare(m.tree, state, workspace);
    Eigen::MatrixXd dq(nv, count), dv(nv, count), da = Eigen::MatrixXd::Constant(nv, count, NAN);
    for (int k = 0; k < count; ++k) {
      Vector one = some(random, nv, 1), other = some(random, nv, 1);
      forget_locked(m.tree, one), forget_locked(m.tree, other);
      dq.col(k) = one, dv.col(k) = other;
    }
    tangent.along(count, dq.data(), dv.data(), da.data());
    // Quadratic drag has no second derivative where its point is at rest: differences are less accurate there.
    bool smooth = true;
    if (!m.tree.loads().bodies.empty()) {
      locate_bodies(m.tree, state, workspace);
      for (const BodyForce& force : m.tree.loads().forces)
        if (m.tree.alive(force.body.index))
          smooth = smooth && norm(workspace.bodies[static_cast<std::size_t>(force.body.index)].velocity.v) > 1e-3;
    }
    const double scale = Eigen::Map<const Vector>(workspace.a.get(), nv).cwiseAbs().maxCoeff();
    for (int k = 0; k < count; ++k) {
      const Path path{m.tree, state, dq.col(k), dv.col(k)};
      double best = INFINITY;
      for (const double h : {3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6})
        best = std::min(best, (path.rate(h) - da.col(k)).cwiseAbs().maxCoeff() / (scale + da.col(k).cwiseAbs().maxCoeff()));
      CHECK(best < (smooth ? 1e-9 : 1e-7));
      ++compared;
    }
  }
  CHECK(compared > 500);
}

// Between states the rows of loops that were chosen at the last one hold, also where others are open by h².
TEST_CASE("derivatives of accelerations of closed loops of all kinds, also with redundant equations and couplings") {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    Prng random(seed + 1000);
    RingOptions options;
    options.tested = random_kind(random);
    if (options.tested == Kind::free || options.tested == Kind::weld) options.tested = Kind::revolute;
    options.floating = seed % 2 == 0, options.planar = seed % 3 == 0, options.coupled = seed % 4 == 1;
    const Model model = random_ring(seed, options).as_loop();
    const World world(model);
    const Tree& tree = world.tree();
    const State& state = world.state();
    REQUIRE(tree.has_loops());
    REQUIRE(state.variables() == Variables::velocities);
    Workspace<double> workspace(tree), other(tree);
    accelerate(tree, state, workspace);
    if (not_differentiable(tree, workspace).part != NotDifferentiable::Part::none) continue;
    AccelerationTangent tangent(tree);
    tangent.prepare(tree, state, workspace);
    const int nv = tree.nv(), count = 3;
    Eigen::MatrixXd dq(nv, count), dv(nv, count), da(nv, count);
    for (int k = 0; k < count; ++k) dq.col(k) = some(random, nv, 1), dv.col(k) = some(random, nv, 1);
    tangent.allow(count, dq.data(), dv.data());
    tangent.along(count, dq.data(), dv.data(), da.data());
    Eigen::MatrixXd again_q = dq, again_v = dv;
    tangent.allow(count, again_q.data(), again_v.data());
    CHECK((again_q - dq).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((again_v - dv).cwiseAbs().maxCoeff() < 1e-9 * (1 + dv.cwiseAbs().maxCoeff()));
    const Vector a = Eigen::Map<const Vector>(workspace.a.get(), nv);
    copy_chosen_rows(tree, workspace, other);
    for (int k = 0; k < count; ++k) {
      const auto at = [&](double h) -> Vector {
        std::vector<double> q(state.q().begin(), state.q().end()), u(state.u().begin(), state.u().end());
        const Vector step = h * dq.col(k);
        displace(tree, step.data(), q.data());
        for (int i = 0; i < nv; ++i) u[static_cast<std::size_t>(i)] += h * dv(i, k);
        evaluate_velocities_without_contacts(tree, 0, q.data(), u.data(), other, LoopRows::kept);
        return Eigen::Map<const Vector>(other.a.get(), nv);
      };
      const double weights[] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
      double best = INFINITY;
      for (const double h : {3e-3, 1e-3, 3e-4, 1e-4, 3e-5}) {
        Vector sum = Vector::Zero(nv);
        for (int n = 1; n <= 4; ++n) sum += weights[n - 1] * (at(n * h) - at(-n * h));
        best = std::min(
            best, (sum / h - da.col(k)).cwiseAbs().maxCoeff() / (a.cwiseAbs().maxCoeff() + da.col(k).cwiseAbs().maxCoeff()));
      }
      CHECK(best < 1e-8);
      ++compared;
    }
  }
  CHECK(compared > 600);
}
