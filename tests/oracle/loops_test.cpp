// Closed loops: accelerations, impacts and changes of random mechanisms with random loops, against the equations of motion as
// dense matrices. The rows of the oracle come from Jacobians of points and from the directions that a joint allows; they share no
// code with the rows of the engine.
#include <cmath>
#include <numbers>
#include <optional>

#include <doctest/doctest.h>

#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/loop_rows.hpp>

using namespace momentree;
using namespace momentree::oracle;

TEST_CASE("loops: accelerations obey the equations of motion with random loops of every kind") {
  int moving = 0, redundant = 0, singular = 0, with_forces = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    CAPTURE(seed);
    const World world(with_loops(seed, true), Variables::velocities);
    const int n = world.tree().nv();
    if (world.loops().empty() || n == 0) continue;
    const Matrix J = rows_of(world), N = null_space(J), M = mass_of(world);
    if (nearly_singular(J)) {
      ++singular;
      continue;
    }
    const Vector u = as_vector(world.v());
    const double speed = 1 + u.cwiseAbs().maxCoeff();
    CHECK((J * u).cwiseAbs().maxCoeff() < 1e-11 * speed);
    CHECK(world.loop_status().residual < 1e-12);
    CHECK(world.loop_status().rows == J.rows());
    CHECK(world.loop_status().rank == n - N.cols());
    redundant += world.loop_status().rank < J.rows() ? 1 : 0;
    if (N.cols() == 0) continue;
    ++moving;
    Vector c(n), tau(n), a = as_vector(world.a());
    world.equations().bias(c.data());
    world.equations().efforts(tau.data());
    // D'Alembert: what is left does no work on motions that the loops allow; on the present one, it has the power of the forces
    // in the loop joints.
    bool forces = false;
    double power = 0, sum = 1;
    for (const JointId loop : world.loops()) {
      const JointView joint = world.joint(loop);
      forces = forces || joint.parameters->any();
      const Values effort = world.joint_forces(loop).effort;
      for (int i = 0; i < effort.size(); ++i) {
        power += effort[i] * joint.v[static_cast<std::size_t>(i)];
        sum += std::fabs(effort[i]) * (1 + std::fabs(joint.v[static_cast<std::size_t>(i)]));
      }
    }
    const Vector left = M * a + c - tau;
    with_forces += power != 0 ? 1 : 0;
    const double allowed = 2e-9 * (sum + u.cwiseAbs().dot(left.cwiseAbs())) + 1e-11 * speed * left.cwiseAbs().sum();  // J u
    CHECK(std::fabs(u.dot(left) - power) < allowed);
    if (!forces) CHECK((N.transpose() * left).cwiseAbs().maxCoeff() < 1e-9 * (1 + left.cwiseAbs().maxCoeff()));
  }
  CHECK(moving > 300);
  CHECK(redundant > 5);
  CHECK(with_forces > 100);
  CHECK(singular < 10);
}

TEST_CASE(
    "loops: making one is a plastic impact, breaking one changes no velocity, and a loop takes the place of a broken joint") {
  int made = 0, replaced = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.min_bodies = 4, options.max_bodies = 9, options.conservative = true;
    const Model model = random_tree(seed, options).model;
    Simulation sim(model, {.method = "dop853"});
    Prng random(seed + 5000);
    const int body = random.integer(0, model.size() - 1), to = random.integer(-1, model.size() - 1);
    if (body == to) continue;
    const std::string one = model[BodyId{body}].name, other = to < 0 ? "ground" : model[BodyId{to}].name;
    const Matrix M = mass_of(sim.world());
    const Vector before = as_vector(sim.world().v());
    JointSpec spec;
    spec.kind = random.chance(0.5) ? Kind::ball : Kind::revolute;
    spec.axis = random.direction();
    const Action attach_them = attach(one, other, spec);
    if (!sim.try_apply({&attach_them, 1}, "grasp")) continue;  // already joined
    const Event& event = sim.events().back();
    const double scale = 1 + event.before.kinetic;
    CHECK(event.lost >= -1e-12 * scale);
    if (sim.world().loops().empty()) continue;
    ++made;
    const Matrix J = rows_of(sim.world()), N = null_space(J);
    const Vector after = as_vector(sim.world().v()), jump = after - before;
    CHECK((J * after).cwiseAbs().maxCoeff() < 1e-10 * (1 + before.cwiseAbs().maxCoeff()));
    const Vector impulse = M * jump;
    if (N.cols() > 0) CHECK((N.transpose() * impulse).cwiseAbs().maxCoeff() < 1e-9 * (1 + impulse.cwiseAbs().maxCoeff()));
    CHECK(std::fabs(0.5 * jump.dot(M * jump) - event.lost) < 1e-9 * scale);

    // A joint between the two bodies breaks: the mechanism moves on as before.
    const std::vector<BodyMotion> motions = sim.world().motions();
    const JointId inboard = sim.world().tree().inboard_joint({body});
    const std::string name(sim.world().joint_name(inboard));
    const Action cut = break_joint(name);
    if (!sim.try_apply({&cut, 1}, "cut")) continue;
    replaced += sim.world().loops().empty() ? 1 : 0;
    double moved = 0, fastest = 1;
    for (std::size_t b = 0; b < motions.size(); ++b) {
      const BodyMotion& now = sim.world().motions()[b];
      moved = std::max({moved, norm(now.linear - motions[b].linear), norm(now.angular - motions[b].angular),
                        norm(now.pose.position - motions[b].pose.position)});
      fastest = std::max({fastest, norm(now.linear), norm(now.angular)});
    }
    CHECK(moved < 1e-9 * fastest);
    CHECK(std::fabs(sim.events().back().lost) < 1e-9 * scale);
  }
  CHECK(made > 150);
  CHECK(replaced > 80);
}

// N windows: N + 1 equal rods on the ground whose tips are joined by bars of the same length as their feet are apart. In motion
// all rods stay parallel: one degree of freedom, θ̈ from the energy. Twice per turn the mechanism lies flat, where the rods could
// part: rows that are nearly dependent there must not decide on the branch.
TEST_CASE("loops: rows of parallelograms pass their singular positions") {
  for (const int windows : {2, 3, 5}) {
    CAPTURE(windows);
    Model model({.gravity = {0, -9.81, 0}});
    const auto name = [](const char* what, int i) { return what + std::to_string(i); };
    for (int i = 0; i <= windows; ++i) {
      BodySpec rod{.name = name("rod", i), .mass = 1, .com = {0, 0.5, 0}, .inertia = diagonal(1.0 / 12, 1e-3, 1.0 / 12)};
      rod.at.position = {1.0 * i, 0, 0};
      rod.joint = JointSpec(Revolute{{0, 0, 1}});
      rod.v = {-1};
      const BodyId foot = model.add(rod);
      if (i == windows) continue;
      BodySpec bar{.name = name("bar", i), .mass = 1, .com = {0.5, 0, 0}, .inertia = diagonal(1e-3, 1.0 / 12, 1.0 / 12)};
      bar.parent = foot;
      bar.at.position = {0, 1, 0};
      bar.joint = JointSpec(Revolute{{0, 0, 1}});
      bar.v = {1};
      model.add(bar);
    }
    for (int i = 0; i < windows; ++i) {
      LoopSpec pin;
      pin.name = name("pin", i), pin.body = model.body(name("bar", i)), pin.to = model.body(name("rod", i + 1));
      pin.joint = JointSpec(Revolute{{0, 0, 1}});
      pin.at.position = {0, 1, 0}, pin.child_at.position = {1, 0, 0};
      model.add_loop(pin);
    }
    Simulation sim(model, {.method = "dop853", .rtol = 1e-11, .atol = 1e-13});
    CHECK(sim.world().loop_status().rank == 2 * windows);
    // Energy of θ, the angle of the rods from the vertical: ½ I θ̇² + G cos θ.
    const double I = (windows + 1) / 3.0 + windows, G = 9.81 * ((windows + 1) * 0.5 + windows);
    const double energy = 0.5 * I + G;
    int turned = 0;
    double last = 0;
    for (int k = 1; k <= 50; ++k) {
      REQUIRE(sim.run_until(0.1 * k).status == Status::ok);
      const double angle = sim.world().joint(model.joint("rod0")).q[0], rate = sim.world().joint(model.joint("rod0")).v[0];
      CHECK(std::fabs(0.5 * I * rate * rate + G * std::cos(angle) - energy) < 1e-6 * energy);
      for (int i = 1; i <= windows; ++i)
        CHECK(std::fabs(std::remainder(sim.world().joint(model.joint(name("rod", i))).q[0] - angle, 2 * std::numbers::pi)) <
              1e-6);
      turned += std::sin(last) * std::sin(angle) < 0 ? 1 : 0;
      last = angle;
    }
    CHECK(turned >= 5);
  }
}

TEST_CASE("loops: impulses move nothing along locks and prescribed motions, and keep the loops closed") {
  int held = 0, driven = 0, singular = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.conservative = true;
    std::optional<Simulation> sim;
    try {
      sim.emplace(with_loops(seed, options, seed % 3 == 0), Integration{.method = "dop853", .variables = Variables::velocities});
    } catch (const Error&) {
      continue;  // the loops do not let a prescribed motion move
    }
    const World& world = sim->world();
    Prng random(seed + 8000);
    for (int k = 0; k < 2; ++k) {
      const Action action = lock(std::string(world.joint_name({random.integer(0, world.model().size() - 1)})));
      static_cast<void>(sim->try_apply(action));  // a weld has nothing to lock
    }
    const Tree& tree = world.tree();
    const int n = tree.nv();
    if (world.loops().empty() || n == 0) continue;
    Matrix J = rows_of(world);
    for (int b = 0; b < tree.bodies(); ++b) {
      const JointView joint = world.joint(tree.inboard_joint({b}));
      for (int i = 0; i < info(tree.kind(b)).nv; ++i) {
        if (!joint.driven && (joint.locked >> i & 1u) == 0) continue;
        J.conservativeResize(J.rows() + 1, n);
        J.row(J.rows() - 1) = Vector::Unit(n, tree.first_p(b) + i).transpose();
        (joint.driven ? driven : held) += 1;
      }
    }
    if (nearly_singular(J)) {
      ++singular;
      continue;
    }
    const Matrix N = null_space(J);
    Vector impulse(n), expected = Vector::Zero(n);
    for (double& x : impulse) x = random.uniform(-1, 1);
    if (N.cols() > 0) {
      const Matrix M = N.transpose() * mass_of(world) * N;
      expected = N * M.ldlt().solve(N.transpose() * impulse);
    }
    Workspace<double> workspace(tree);
    accelerate(tree, world.state(), workspace);
    Vector change = impulse;
    solve_with_loops(tree, world.state().q().data(), workspace, change.data());
    CHECK((change - expected).cwiseAbs().maxCoeff() < 1e-7 * (1 + expected.cwiseAbs().maxCoeff()));
  }
  CHECK(held > 500);
  CHECK(driven > 50);
  CHECK(singular < 30);
}

TEST_CASE("loops: energy and momenta of free mechanisms with loops are conserved, and the loops stay closed") {
  int runs = 0;
  for (std::uint64_t seed = 0; seed < 300 && runs < 40; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.min_bodies = 3, options.max_bodies = 7, options.all_free = true, options.gravity = false, options.parameters = false;
    options.several_mechanisms = false;
    Model model = random_tree(seed, options).model;
    Prng random(seed + 9000);
    LoopSpec loop;
    loop.name = "clasp", loop.body = {model.size() - 1}, loop.to = {0};
    loop.joint.kind = Kind::ball;
    const World open(model);
    loop.at = inverse(side(open, loop.to, {})) * side(open, loop.body, {});
    model.add_loop(loop);
    Simulation sim(model, {.method = "dop853", .rtol = 1e-11, .atol = 1e-12});
    const Totals start = sim.world().totals();
    if (start.kinetic < 1e-6) continue;
    const RunResult run = sim.run_until(0.5);
    if (run.status == Status::stalled) continue;
    REQUIRE_MESSAGE(run.status == Status::ok, run.reason);
    ++runs;
    const Totals end = sim.world().totals();
    CHECK(std::fabs(end.kinetic - start.kinetic) < 1e-8 * start.kinetic);
    CHECK(norm(end.linear - start.linear) < 1e-9 * (1e-3 + norm(start.linear)));
    CHECK(norm(end.angular - start.angular) < 1e-8 * (1e-3 + norm(start.angular)));
    CHECK(sim.world().loop_status().residual < 1e-12);
  }
  CHECK(runs >= 40);
}
