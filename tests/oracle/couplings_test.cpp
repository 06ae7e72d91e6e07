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
    world.equations().bias(c.data());
    world.equations().efforts(tau.data());
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
}

TEST_CASE("couplings: locking a joint is a plastic impact, and locks what is coupled; breaking one changes no velocity") {
  int locked = 0, ended = 0, rerooted = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.min_bodies = 4, options.max_bodies = 9, options.conservative = true;
    options.kinds = {Kind::revolute, Kind::prismatic, Kind::helical, Kind::ball};
    Model model = random_tree(seed, options).model;
    couple(model, seed);
    if (model.couplings().empty()) continue;
    Simulation sim(model, {.method = "dop853"});
    Prng random(seed + 31);
    const Coupling& first = model.couplings().front();
    const JointId joint = first.follows.index >= 0 && random.chance(0.5) ? first.follows : first.joint;
    const Matrix M = mass_of(sim.world());
    const Vector before = as_vector(sim.world().v());
    const std::string name = model[joint].joint_name;
    sim.apply(lock(name), "lock");
    const Event event = sim.events().back();
    Matrix held = Matrix::Zero(1, M.cols());
    held(0, dof_of(sim.world(), joint)) = 1;
    const Matrix J = stacked(coupling_rows(sim.world()), held), N = null_space(J);
    if (nearly_singular(J)) continue;
    const Vector after = as_vector(sim.world().v()), jump = after - before, impulse = M * jump;
    CHECK((J * after).cwiseAbs().maxCoeff() < 1e-10 * (1 + before.cwiseAbs().maxCoeff()));
    if (N.cols() > 0) CHECK((N.transpose() * impulse).cwiseAbs().maxCoeff() < 1e-9 * (1 + impulse.cwiseAbs().maxCoeff()));
    const double lost = event.lost + event.released;  // with a rotor that the lock stops
    CHECK(std::fabs(0.5 * jump.dot(M * jump) - lost) < 1e-9 * (1 + event.before.kinetic));
    // What is not at the lock is the couplings' impulse.
    Vector coupled = Vector::Zero(M.cols());
    for (const Event::OfCoupling& each : event.coupling_impulse) {
      coupled(dof_of(sim.world(), model.joint(each.joint))) += each.on_joint;
      if (!each.follows.empty()) coupled(dof_of(sim.world(), model.joint(each.follows))) += each.on_follows;
    }
    Vector rest = impulse - coupled;
    rest(dof_of(sim.world(), joint)) = 0;
    CHECK(rest.cwiseAbs().maxCoeff() < 1e-8 * (1 + impulse.cwiseAbs().maxCoeff()));
    ++locked;

    // A body floats away and is caught again by another: the joints of its part may then be evaluated in the other direction.
    sim.apply(unlock(name), "unlock");
    const int cut = random.integer(0, model.size() - 1);
    const Action part = break_joint(model[BodyId{cut}].joint_name);
    const Vector moving = as_vector(sim.world().v());
    std::vector<double> rates;
    for (int b = 0; b < model.size(); ++b)
      if (b != cut)
        for (const double v : sim.world().joint({b}).v) rates.push_back(v);
    if (!sim.try_apply({&part, 1}, "cut")) continue;
    int gone = 0;
    for (int c = 0; c < sim.world().couplings(); ++c) {
      const Coupling& law = model.couplings()[static_cast<std::size_t>(c)];
      const bool of_part = law.joint.index == cut || law.follows.index == cut;
      CHECK(sim.world().coupling({c}).ended == of_part);
      gone += of_part ? 1 : 0;
    }
    CHECK(sim.events().back().topology.ended_couplings.size() == static_cast<std::size_t>(gone));
    ended += gone;
    std::size_t i = 0;
    double changed = 0;
    for (int b = 0; b < model.size(); ++b)
      if (b != cut)
        for (const double v : sim.world().joint({b}).v) changed = std::max(changed, std::fabs(v - rates[i++]));
    CHECK(changed < 1e-9 * (1 + moving.cwiseAbs().maxCoeff()));
    const int caught = random.integer(0, model.size() - 1);
    const Action grasp = attach(model[BodyId{caught}].name, "ground", JointSpec(Ball{}));
    if (!sim.try_apply({&grasp, 1}, "grasp")) continue;
    for (int b = 0; b < model.size(); ++b) rerooted += sim.world().joint({b}).reversed ? 1 : 0;
    const World& world = sim.world();
    const Matrix Jl = rows_of(world), Jc = coupling_rows(world), Jn = stacked(Jl, Jc);
    if (Jn.rows() == 0 || nearly_singular(Jn)) continue;
    const Vector u = as_vector(world.v());
    CHECK((Jn * u).cwiseAbs().maxCoeff() < 1e-9 * (1 + u.cwiseAbs().maxCoeff()));
    CHECK(world.loop_status().residual < 1e-9);
    Vector c(world.tree().nv()), tau(world.tree().nv()), lambda(Jc.rows());
    world.equations().bias(c.data());
    world.equations().efforts(tau.data());
    int row = 0;
    for (int k = 0; k < world.couplings(); ++k)
      if (const CouplingView view = world.coupling({k}); !view.ended) lambda(row++) = view.effort;
    const Vector left = mass_of(world) * as_vector(world.a()) + c - tau - Jc.transpose() * lambda;
    const Matrix Nl = Jl.rows() > 0 ? null_space(Jl) : Matrix(Matrix::Identity(Jc.cols(), Jc.cols()));
    if (Nl.cols() > 0)
      CHECK((Nl.transpose() * left).cwiseAbs().maxCoeff() < 1e-7 * (1 + tau.cwiseAbs().maxCoeff() + lambda.cwiseAbs().sum()));
  }
  CHECK(locked > 100);
  CHECK(ended > 20);
  CHECK(rerooted > 20);
}

TEST_CASE("couplings: energy and momentum are conserved in random mechanisms") {
  int runs = 0;
  for (std::uint64_t seed = 0; runs < 40; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.min_bodies = 3, options.max_bodies = 6, options.conservative = true, options.parameters = false;
    options.gravity = false, options.all_free = true, options.several_mechanisms = false;
    options.kinds = {Kind::revolute, Kind::prismatic, Kind::helical};
    Model model = random_tree(seed, options).model;
    couple(model, seed);
    if (model.couplings().empty()) continue;
    Simulation sim(model, {.method = "dop853", .rtol = 1e-11, .atol = 1e-13});
    const Totals start = sim.world().totals();
    if (!sim.run_until(0.3)) continue;  // some are thrown into singular positions by their polynomials
    ++runs;
    const Totals end = sim.world().totals();
    CHECK(std::fabs(end.kinetic - start.kinetic) < 1e-8 * start.kinetic);
    CHECK(std::fabs(sim.energy().work) < 1e-12);
    CHECK(norm(end.linear - start.linear) < 1e-9 * (1e-3 + norm(start.linear)));
    CHECK(norm(end.angular - start.angular) < 1e-8 * (1e-3 + norm(start.angular)));
    CHECK(sim.world().loop_status().residual < 1e-11);
  }
}

namespace {

BodySpec wheel(const char* name, double inertia, Vec3 axis = {0, 0, 1}) {
  BodySpec spec{.name = name, .mass = 1, .inertia = diagonal(inertia)};
  spec.joint = JointSpec(Revolute{axis});
  return spec;
}

}  // namespace

TEST_CASE("couplings: a pair of gears turns as one inertia, and the effort between them is known") {
  Model model;
  BodySpec motor = wheel("motor", 0.01);
  motor.joint.parameters.effort = {0.5}, motor.joint.parameters.armature = {0.003};
  const BodyId a = model.add(motor), b = model.add(wheel("load", 2));
  model.add_coupling({.joint = {b.index}, .follows = {a.index}, .multiplier = -0.1, .offset = 0.3});
  Simulation sim(model, {.method = "rk4", .step = 0.01});
  const double inertia = 0.013 + 0.01 * 2, acceleration = 0.5 / inertia;
  CHECK(sim.world().joint({b.index}).q[0] == 0.3);  // it follows
  CHECK(sim.world().a()[0] == doctest::Approx(acceleration).epsilon(1e-13));
  CHECK(sim.world().coupling({0}).effort == doctest::Approx(-0.1 * 2 * acceleration).epsilon(1e-13));
  REQUIRE(sim.run_until(1));
  CHECK(sim.world().joint({a.index}).q[0] == doctest::Approx(0.5 * acceleration).epsilon(1e-12));
  CHECK(sim.world().joint({b.index}).q[0] == doctest::Approx(0.3 - 0.05 * acceleration).epsilon(1e-12));
  CHECK(sim.energy().work == doctest::Approx(0.5 * 0.5 * acceleration).epsilon(1e-12));
}

TEST_CASE("couplings: a rack on a pinion falls as under a larger mass") {
  const double r = 0.05, m = 3, I = 0.02, g = 9.81;
  Model model;
  const BodyId pinion = model.add(wheel("pinion", I));
  BodySpec bar{.name = "rack", .mass = m};
  bar.joint = JointSpec(Prismatic{{0, 0, 1}});
  const BodyId rack = model.add(bar);
  model.add_coupling({.joint = {rack.index}, .follows = {pinion.index}, .multiplier = r});
  Simulation sim(model, {.method = "rk4", .step = 0.01});
  const double acceleration = -g * m / (m + I / (r * r));
  REQUIRE(sim.run_until(2));
  CHECK(sim.world().joint({rack.index}).q[0] == doctest::Approx(2 * acceleration).epsilon(1e-12));
  CHECK(sim.world().joint({pinion.index}).v[0] == doctest::Approx(2 * acceleration / r).epsilon(1e-12));
  CHECK(sim.world().coupling({0}).effort == doctest::Approx(m * (acceleration + g)).epsilon(1e-12));
  CHECK(std::fabs(sim.energy().error) < 1e-10);
}

// Both links of a double pendulum, the second one's angle relative to the first being f(θ): one coordinate, eliminated by hand.
TEST_CASE("couplings: an arm moves as its model with the coupled joint eliminated") {
  const double m1 = 2, l1 = 0.7, c1 = 0.3, I1 = 0.05, m2 = 1.2, c2 = 0.25, I2 = 0.03, g = 9.81;
  Coupling law{.joint = {1}, .follows = {0}, .multiplier = -1.5, .offset = 0.2, .higher = {0.4, 0.1, -0.05}};
  Model model;
  BodySpec upper{.name = "upper", .mass = m1, .com = {c1, 0, 0}, .inertia = diagonal(I1)};
  upper.joint = JointSpec(Revolute{{0, -1, 0}});
  upper.q = {0.4}, upper.v = {0.3};
  BodySpec lower{.name = "lower", .mass = m2, .com = {c2, 0, 0}, .inertia = diagonal(I2)};
  lower.joint = JointSpec(Revolute{{0, -1, 0}});
  lower.parent = model.add(upper), lower.at.position = {l1, 0, 0};
  model.add(lower);
  model.add_coupling(law);
  Simulation sim(model, {.method = "dop853", .rtol = 1e-12, .atol = 1e-13});
  // T = ½ A(θ) θ̇², with the angular velocity (1 + f′) θ̇ of the lower link; A′ and V′ by hand.
  const auto rates = [&](double x, double v, double& dx, double& dv) {
    const double f = value(law, x), s = slope(law, x), k = curvature(law, x), w = 1 + s;
    const double A = I1 + m1 * c1 * c1 + m2 * l1 * l1 + (I2 + m2 * c2 * c2) * w * w + 2 * m2 * l1 * c2 * std::cos(f) * w;
    const double dA = 2 * (I2 + m2 * c2 * c2) * w * k + 2 * m2 * l1 * c2 * (std::cos(f) * k - std::sin(f) * s * w);
    const double dV = g * ((m1 * c1 + m2 * l1) * std::cos(x) + m2 * c2 * std::cos(x + f) * w);
    dx = v, dv = -(0.5 * dA * v * v + dV) / A;
  };
  double x = 0.4, v = 0.3;
  const int steps = 4000;
  const double h = 1.0 / steps;
  for (int i = 0; i < steps; ++i) {
    double a1, b1, a2, b2, a3, b3, a4, b4;
    rates(x, v, a1, b1);
    rates(x + h / 2 * a1, v + h / 2 * b1, a2, b2);
    rates(x + h / 2 * a2, v + h / 2 * b2, a3, b3);
    rates(x + h * a3, v + h * b3, a4, b4);
    x += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4), v += h / 6 * (b1 + 2 * b2 + 2 * b3 + b4);
  }
  REQUIRE(sim.run_until(1));
  CHECK(sim.world().joint({0}).q[0] == doctest::Approx(x).epsilon(1e-9));
  CHECK(sim.world().joint({0}).v[0] == doctest::Approx(v).epsilon(1e-9));
  CHECK(sim.world().joint(law.joint).q[0] == doctest::Approx(value(law, x)).epsilon(1e-9));
}
