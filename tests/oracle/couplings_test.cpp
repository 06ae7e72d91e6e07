// Exact couplings of joints: accelerations, efforts, impacts and changes of random mechanisms with couplings and loops, against
// the equations of motion as dense matrices; and mechanisms with closed forms.
#include <cmath>

#include <doctest/doctest.h>

#include <tests/oracle/loop_rows.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

double value(const Coupling& c, double x) {
  return c.follows.index < 0
             ? c.offset
             : c.offset + c.multiplier * x + c.higher[0] * x * x + c.higher[1] * x * x * x + c.higher[2] * x * x * x * x;
}
// By differences: the polynomial has degree 4, so these formulas are exact but for rounding.
double slope(const Coupling& c, double x) {
  const auto central = [&](double h) { return (value(c, x + h) - value(c, x - h)) / (2 * h); };
  return (4 * central(0.5) - central(1)) / 3;
}
double curvature(const Coupling& c, double x) {
  const auto second = [&](double h) { return (value(c, x + h) - 2 * value(c, x) + value(c, x - h)) / (h * h); };
  return (4 * second(0.5) - second(1)) / 3;
}

double q_of(const World& world, JointId joint) { return joint.index < 0 ? 0 : world.joint(joint).q[0]; }
double v_of(const World& world, JointId joint) { return joint.index < 0 ? 0 : world.joint(joint).v[0]; }
int dof_of(const World& world, JointId joint) { return world.tree().first_p(world.tree().carrier(joint.index)); }

// Rows of the couplings that act, one each.
Matrix coupling_rows(const World& world) {
  Matrix J(0, world.tree().nv());
  for (int c = 0; c < world.couplings(); ++c) {
    const CouplingView view = world.coupling({c});
    if (view.ended) continue;
    J.conservativeResize(J.rows() + 1, Eigen::NoChange);
    J.row(J.rows() - 1).setZero();
    J(J.rows() - 1, dof_of(world, view.coupling.joint)) = 1;
    if (view.coupling.follows.index >= 0)
      J(J.rows() - 1, dof_of(world, view.coupling.follows)) -= slope(view.coupling, q_of(world, view.coupling.follows));
  }
  return J;
}

Matrix stacked(const Matrix& one, const Matrix& other) {
  Matrix all(one.rows() + other.rows(), one.cols());
  all << one, other;
  return all;
}

// Up to four random couplings, which hold at the start.
void couple(Model& model, std::uint64_t seed) {
  Prng random(seed + 77);
  std::vector<int> single;
  for (int b = 0; b < model.size(); ++b)
    if (info(model[BodyId{b}].joint.kind).nv == 1) single.push_back(b);
  if (single.empty()) return;
  const auto any = [&] { return single[static_cast<std::size_t>(random.integer(0, static_cast<int>(single.size()) - 1))]; };
  std::vector<char> coupled(static_cast<std::size_t>(model.size()), 0);
  for (int k = random.integer(1, 4); k > 0; --k) {
    Coupling coupling;
    coupling.joint = {any()};
    if (random.chance(0.9)) coupling.follows = {any()};
    if (coupling.joint == coupling.follows) continue;
    coupling.multiplier = random.uniform(-3, 3);
    if (random.chance(0.5)) coupling.higher = {random.uniform(-1, 1), random.uniform(-0.5, 0.5), random.uniform(-0.3, 0.3)};
    const double x = coupling.follows.index < 0 ? 0 : model[coupling.follows].q[0];
    coupling.offset = model[coupling.joint].q[0] - value(coupling, x);
    model.add_coupling(coupling);
  }
}

}  // namespace

TEST_CASE("couplings: accelerations and efforts obey the equations of motion in random trees with loops") {
  int moving = 0, redundant = 0, singular = 0, with_loops_too = 0, open = 0;
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.min_bodies = 3, options.max_bodies = 9;
    if (seed % 2 == 0) options.kinds = {Kind::revolute, Kind::prismatic, Kind::helical, Kind::revolute, Kind::ball};
    Model model = seed % 3 == 0 ? with_loops(seed, true) : random_tree(seed, options).model;
    couple(model, seed);
    if (model.couplings().empty()) continue;
    const World world(model, Variables::velocities);
    const int n = world.tree().nv();
    const Matrix Jl = rows_of(world), Jc = coupling_rows(world), J = stacked(Jl, Jc), N = null_space(J), M = mass_of(world);
    if (nearly_singular(J)) {
      ++singular;
      continue;
    }
    const Vector u = as_vector(world.v());
    const double speed = 1 + u.cwiseAbs().maxCoeff();
    CHECK((J * u).cwiseAbs().maxCoeff() < 1e-10 * speed);
    CHECK(world.loop_status().residual < 1e-12);
    CHECK(world.loop_status().rows == J.rows());
    CHECK(world.loop_status().rank == n - N.cols());
    redundant += world.loop_status().rank < J.rows() ? 1 : 0;
    Vector c(n), tau(n), a = as_vector(world.a());
    world.bias(c.data());
    world.efforts(tau.data());
    const double fast = 1 + a.cwiseAbs().maxCoeff() + speed * speed;
    int row = 0;
    Vector lambda = Vector::Zero(Jc.rows());
    for (int k = 0; k < world.couplings(); ++k) {
      const CouplingView view = world.coupling({k});
      const Coupling& law = view.coupling;
      CHECK(std::fabs(q_of(world, law.joint) - value(law, q_of(world, law.follows))) < 1e-12);
      const double rate = v_of(world, law.follows);
      const double drift = law.follows.index < 0 ? 0 : curvature(law, q_of(world, law.follows)) * rate * rate;
      CHECK(std::fabs(Jc.row(row).dot(a) - drift) < 1e-8 * fast);
      lambda(row++) = view.effort;
      open += view.determined ? 0 : 1;
    }
    if (N.cols() > 0) ++moving;
    with_loops_too += Jl.rows() > 0 ? 1 : 0;
    bool forces = false;
    for (const JointId loop : world.loops()) forces = forces || world.joint(loop).parameters->any();
    if (forces) continue;
    const Vector left = M * a + c - tau;
    const double size = 1 + left.cwiseAbs().maxCoeff() + lambda.cwiseAbs().maxCoeff();
    if (N.cols() > 0) CHECK((N.transpose() * left).cwiseAbs().maxCoeff() < 1e-8 * size);
    // The efforts of the couplings are what the loops do not explain.
    const Vector rest = left - Jc.transpose() * lambda;
    if (Jl.rows() == 0)
      CHECK(rest.cwiseAbs().maxCoeff() < 1e-8 * size);
    else if (const Matrix Nl = null_space(Jl); Nl.cols() > 0)
      CHECK((Nl.transpose() * rest).cwiseAbs().maxCoeff() < 1e-8 * size);
    // What a joint transmits along its DoF contains the coupling's effort.
    const Vector along = Jc.transpose() * lambda;
    for (int b = 0; b < model.size(); ++b) {
      const Values effort = world.joint_forces({b}).effort;
      for (int i = 0; i < effort.size(); ++i) {
        const int dof = world.tree().first_p(world.tree().carrier(b)) + i;
        CHECK(std::fabs(effort[i] - tau(dof) - along(dof)) < 1e-8 * size);
      }
    }
  }
  CHECK(moving > 700);
  CHECK(redundant > 20);
  CHECK(with_loops_too > 200);
  CHECK(singular < 60);
  MESSAGE(moving << " " << redundant << " " << with_loops_too << " " << singular << " " << open);
}
