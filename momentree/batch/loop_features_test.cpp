// Prescribed motions and armatures of loop joints, and exact couplings, in batches in momenta; functions of loop joints are
// refused.
#include <algorithm>
#include <memory>
#include <span>
#include <string>

#include <doctest/doctest.h>

#include <momentree/batch/batch.hpp>
#include <momentree/batch/group.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {
namespace {

constexpr double h = 0x1p-10;  // s; sums of such steps are exact

/// A slide on the ground, an arm on it, and a second arm on the ground that carries the first one's tip in a guide.
Model guided(const JointParameters& parameters) {
  Model model;
  const BodyId arm = model.add({.name = "m/arm",
                                .mass = 1,
                                .com = {0.2, 0, 0},
                                .inertia = diagonal(0.01, 0.02, 0.02),
                                .joint = Revolute{.axis = y_axis},
                                .q = 0.4,
                                .v = 1.0});
  const BodyId guide = model.add({.name = "m/guide",
                                  .mass = 2,
                                  .com = {0.1, 0, 0.1},
                                  .inertia = diagonal(0.03, 0.04, 0.05),
                                  .at = {0.5, 0, -0.3},
                                  .joint = Revolute{.axis = y_axis},
                                  .q = 0.8});
  const BodyId shoe = model.add({.name = "m/shoe",
                                 .mass = 0.5,
                                 .inertia = diagonal(0.01),
                                 .parent = arm,
                                 .at = {0.4, 0, 0},
                                 .joint = Revolute{.axis = y_axis},
                                 .q = 0.4});
  LoopSpec slot{.name = "slot", .body = shoe, .to = guide};
  slot.joint = Prismatic{.axis = x_axis};
  slot.joint.parameters = parameters;
  model.add_loop(slot);
  return model;
}

Model gears() {
  Model model;
  model.add({.name = "g/one", .mass = 1, .inertia = diagonal(0.02), .joint = Revolute{.axis = y_axis}, .v = 3.0});
  model.add({.name = "g/rack", .mass = 1, .inertia = diagonal(0.01), .joint = Prismatic{.axis = z_axis, .stiffness = 10.0}});
  model.add_coupling({.joint = {1}, .follows = {0}, .multiplier = 0.1, .higher = {0.02, 0, 0}});
  return model;
}

void check_bits(const Batch& batch, int world, const Simulation& sim) {
  const State one = batch.state(world);
  const State& other = sim.world().state();
  CHECK(one.variables() == other.variables());
  CHECK(one.time() == other.time());
  CHECK(std::ranges::equal(one.q(), other.q()));
  CHECK(std::ranges::equal(one.y(), other.y()));
}

}  // namespace

TEST_CASE("in momenta, motions and armatures of loop joints, and couplings, have the bits of simulations") {
  const JointParameters moved{.drive = motion_drive(Signal::sine(0.05, 1, 0, -0.2))}, heavy{.damping = 3.0, .armature = 2.0};
  for (const Model& model : {guided(moved), guided(heavy), gears()}) {
    Batch batch(model, 3, {.variables = Variables::momenta});
    Simulation sim(model, {.method = "rk4", .variables = Variables::momenta, .step = h});
    CHECK(batch.variables(1) == Variables::momenta);
    check_bits(batch, 1, sim);
    for (int step = 0; step < 30; ++step) batch.step(h);
    REQUIRE(sim.run_until(30 * h) == Status::ok);
    check_bits(batch, 1, sim);
    if (model.loops().empty()) continue;
    const Action change = set_parameters("slot", {.armature = 0.5});
    batch.apply(1, change, "change");
    sim.apply(change, "change");
    for (int step = 0; step < 10; ++step) batch.step(h);
    REQUIRE(sim.run_until(40 * h) == Status::ok);
    check_bits(batch, 1, sim);
  }
}

TEST_CASE("batches refuse functions of loop joints") {
  Tree tree(guided({}));
  CHECK_FALSE(batch::unsupported(tree));
  tree.edit().set_loop_function(0, std::make_shared<const JointFunction>([](const EvaluationContext&, std::span<double>) {}));
  CHECK(has_functions(tree));
  REQUIRE(batch::unsupported(tree));
  CHECK(std::string(batch::unsupported(tree)->problem).find("functions") != std::string::npos);
  tree.edit().set_loop_function(0, nullptr);
  CHECK_FALSE(has_functions(tree));
  CHECK_FALSE(batch::unsupported(tree));
}

}  // namespace momentree
