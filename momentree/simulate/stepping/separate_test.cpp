// Bodies that overlap at the start and are pushed apart.
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/simulate/stepping/overlap.hpp>
#include <tests/error_of.hpp>

using namespace momentree;

namespace {

const Integration pushed_apart{.method = "dop853", .resolve = true};

BodyId add_box(Model& model, const std::string& name, double mass, const Vec3& at, const Vec3& sides = {0.2, 0.2, 0.2}) {
  const BodyId body = model.add({.name = name,
                                 .mass = mass,
                                 .inertia = diagonal(0.01 * mass),
                                 .joint = Free{},
                                 .q = {at.x, at.y, at.z, 1, 0, 0, 0},
                                 .v = {0.1, 0, 0, 0, 0, 0.2}});
  model.add_collider({.body = body, .solid = contact::box(sides)});
  return body;
}

Pose pose_of(const Simulation& sim, BodyId body) { return sim.world().motions()[static_cast<std::size_t>(body.index)].pose; }

// The distance of a body to where it was put, and how far it turned.
double moved(const Simulation& sim, BodyId body, const Vec3& from) {
  const Pose pose = pose_of(sim, body);
  return norm(pose.position - from) + std::fabs(pose.rotation.x) + std::fabs(pose.rotation.y) + std::fabs(pose.rotation.z);
}

}  // namespace

TEST_CASE("overlaps: a box in the floor ends exactly on it, and nothing else moves") {
  Model model;
  const BodyId sunk = add_box(model, "sunk", 2, {0, 0, 0.095}), lies = add_box(model, "lies", 1, {1, 0, 0.1});
  const BodyId flies = add_box(model, "flies", 1, {0, 1, 3});
  model.add_collider({.plane = true});
  CHECK(deepest_overlap(model)->depth == doctest::Approx(0.005));
  const Simulation sim(model, pushed_apart);
  CHECK(moved(sim, sunk, {0, 0, 0.1}) < 1e-14);
  CHECK(moved(sim, lies, {1, 0, 0.1}) < 1e-15);
  CHECK(moved(sim, flies, {0, 1, 3}) < 1e-15);
  CHECK(norm(sim.world().motions()[0].linear - Vec3{0.1, 0, 0}) < 1e-15);
  const Separation separation = separation_of(model);
  CHECK(separation.largest == doctest::Approx(0.005).epsilon(1e-12));
  CHECK(separation.body == "sunk");
  CHECK_FALSE(separation.left.has_value());
  // What does not overlap is left as it is, to the bit.
  const Simulation again(model, {.method = "dop853"});
  Model apart;
  add_box(apart, "lies", 1, {1, 0, 0.1}), apart.add_collider({.plane = true});
  const Simulation with(apart, pushed_apart), without(apart, {.method = "dop853"});
  CHECK(std::equal(with.world().state().q().begin(), with.world().state().q().end(), without.world().state().q().begin()));
  CHECK(separation_of(apart).largest == 0);
}

TEST_CASE("overlaps: without resolve the run ends, and says what to do") {
  Model model;
  add_box(model, "sunk", 2, {0, 0, 0.095});
  model.add_collider({.plane = true});
  Simulation sim(model);
  const RunResult run = sim.run_until(1);
  CHECK(run.status == Status::stalled);
  CHECK(run.reason.find("'sunk' and 'ground' overlap by 0.005 m") != std::string::npos);
  CHECK(run.reason.find("resolve = true") != std::string::npos);
}

TEST_CASE("overlaps: two boxes share the motion by their masses") {
  Model model(Model::Options{Vec3{}});
  const BodyId light = add_box(model, "light", 1, {0, 0, 0}), heavy = add_box(model, "heavy", 3, {0.196, 0.01, 0.02});
  const Simulation sim(model, pushed_apart);
  CHECK(norm(pose_of(sim, light).position - Vec3{-0.003, 0, 0}) < 1e-3);  // they turn, too, as the overlap is aside
  const double change =
      norm(1 * (pose_of(sim, light).position - Vec3{}) + 3 * (pose_of(sim, heavy).position - Vec3{0.196, 0.01, 0.02}));
  CHECK(change < 1e-12);
  CHECK(std::fabs(sim.world().gap(light, heavy)->distance) < 1e-12);
  Model central(Model::Options{Vec3{}});
  const BodyId one = add_box(central, "one", 1, {0, 0, 0}), other = add_box(central, "other", 3, {0.196, 0, 0});
  const Simulation exact(central, pushed_apart);
  CHECK(moved(exact, one, {-0.003, 0, 0}) < 1e-14);
  CHECK(moved(exact, other, {0.197, 0, 0}) < 1e-14);
}

TEST_CASE("overlaps: joints stay within their stops") {
  Model model;
  const auto slider = [&](const char* name, double mass, double x, double lower) {
    const BodyId body = model.add({.name = name,
                                   .mass = mass,
                                   .inertia = diagonal(0.01),
                                   .joint = Prismatic{.axis = {1, 0, 0}, .limits = {.lower = {lower}}},
                                   .q = {x}});
    model.add_collider({.body = body, .solid = contact::box({0.2, 0.2, 0.2})});
  };
  slider("light", 1, 0, -0.001), slider("heavy", 3, 0.196, -1);
  const Simulation sim(model, pushed_apart);
  CHECK(sim.world().state().q()[0] == doctest::Approx(-0.001).epsilon(1e-12));
  CHECK(sim.world().state().q()[1] == doctest::Approx(0.199).epsilon(1e-12));
}

TEST_CASE("overlaps: the ends of cables that are too short are brought together") {
  Model model(Model::Options{Vec3{}});
  const BodyId light = add_box(model, "light", 1, {0, 0, 0}), heavy = add_box(model, "heavy", 3, {1.004, 0, 0});
  model.add_cable({.name = "rope", .from = {light, {}}, .to = {heavy, {}}, .length = 1});
  REQUIRE(deepest_overlap(model)->cable == "rope");
  const Simulation sim(model, pushed_apart);
  CHECK(moved(sim, light, {0.003, 0, 0}) < 1e-14);
  CHECK(moved(sim, heavy, {1.003, 0, 0}) < 1e-14);
}

TEST_CASE("overlaps: a closed loop that is in the floor stays closed") {
  // A parallelogram, whose coupler is a ball's diameter below the floor.
  Model model;
  const auto arm = [&](const char* name, double x) {
    return model.add({.name = name,
                      .mass = 1,
                      .com = {0, 0, -0.2},
                      .inertia = diagonal(0.01),
                      .at = Pose(Vec3{x, 0, 0.4}),
                      .joint = Revolute{.axis = {0, 1, 0}},
                      .q = {0.3}});
  };
  const BodyId left = arm("left", 0), right = arm("right", 0.5);
  const BodyId coupler = model.add({.name = "coupler",
                                    .mass = 2,
                                    .com = {0.25, 0, 0},
                                    .inertia = diagonal(0.05),
                                    .parent = left,
                                    .at = Pose(Vec3{0, 0, -0.4}),
                                    .joint = Revolute{.axis = {0, 1, 0}},
                                    .q = {-0.3}});
  model.add_loop({.name = "pin",
                  .body = coupler,
                  .to = right,
                  .joint = Revolute{.axis = {0, 1, 0}},
                  .at = Pose(Vec3{0, 0, -0.4}),
                  .child_at = Pose(Vec3{0.5, 0, 0})});
  model.add_collider({.body = coupler, .solid = contact::sphere(0.05, Pose(Vec3{0.25, 0, 0}))});
  model.add_collider({.plane = true});
  REQUIRE(deepest_overlap(model)->depth > 0.01);
  Simulation sim(model, pushed_apart);
  CHECK(std::fabs(sim.world().gap(coupler, ground)->distance) < 1e-12);
  const auto& q = sim.world().state().q();
  CHECK(std::fabs(0.4 - 0.4 * std::cos(q[0]) - 0.05) < 1e-12);
  CHECK(q[1] == doctest::Approx(q[0]).epsilon(1e-12));
  CHECK(sim.run_until(0.1));
}

TEST_CASE("overlaps: a chain bends as little as possible until its link lies on the floor") {
  Model model;
  BodyId last = ground;
  std::vector<BodyId> links;
  for (const char* name : {"a", "b", "c"}) {
    last = model.add({.name = std::string("chain/") + name,
                      .mass = 1,
                      .com = {0.2, 0, 0},
                      .inertia = diagonal(1e-3, 0.013, 0.013),
                      .parent = last,
                      .at = Pose(links.empty() ? Vec3{0, 0, 0.6} : Vec3{0.4, 0, 0}),
                      .joint = Revolute{{0, 1, 0}},
                      .q = {links.empty() ? 0.8 : -0.2}});
    links.push_back(last);
    model.add_collider(
        {.body = last, .solid = contact::capsule(0.02, 0.4, Pose(Vec3{0.2, 0, 0}, Quat{std::sqrt(0.5), 0, std::sqrt(0.5), 0}))});
  }
  model.add_collider({.plane = true});
  const double depth = deepest_overlap(model)->depth;
  REQUIRE(depth > 0.01);
  const Simulation sim(model, pushed_apart), start(model);
  CHECK(std::fabs(sim.world().gap(last, ground)->distance) < 1e-12);
  for (const BodyId link : links) CHECK(sim.world().gap(link, ground)->distance > -1e-12);
  // Of all motions that lift the link, to first order: the displacement is M⁻¹ Jᵀ times a number. Others along the floor are
  // longer.
  const auto length = [&](const std::vector<double>& by) {
    // Twice the kinetic energy of the velocities `by`, where the chain ended.
    Model moving = model;
    Simulation now(moving);
    std::vector<double> q(sim.world().state().q().begin(), sim.world().state().q().end());
    now.set_state(0, q, by, Variables::velocities);
    return 2 * now.world().totals().kinetic;
  };
  std::vector<double> least;
  for (std::size_t i = 0; i < 3; ++i) least.push_back(sim.world().state().q()[i] - start.world().state().q()[i]);
  const auto height = [&](const std::vector<double>& q) {
    double angle = 0, z = 0.6;
    for (const double turn : q) angle += turn, z -= 0.4 * std::sin(angle);
    return z - 0.02;
  };
  const std::vector<double> q(sim.world().state().q().begin(), sim.world().state().q().end());
  CHECK(std::fabs(height(q)) < 1e-12);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 20; ++k) {
    std::vector<double> other = least;
    double slope = 0, along = 0;
    std::vector<double> direction(3), gradient(3);
    for (std::size_t i = 0; i < 3; ++i) {
      std::vector<double> shifted = q;
      shifted[i] += 1e-6;
      gradient[i] = (height(shifted) - height(q)) / 1e-6, direction[i] = 0.01 * normal(random);
      slope += gradient[i] * gradient[i], along += gradient[i] * direction[i];
    }
    for (std::size_t i = 0; i < 3; ++i) other[i] += direction[i] - along / slope * gradient[i];
    CHECK(length(other) > length(least));
  }
}

TEST_CASE("overlaps: piles of boxes and balls come apart") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  for (int k = 0; k < 10; ++k) {
    Model model;
    for (int i = 0; i < 12; ++i) {
      const BodyId body =
          add_box(model, "box" + std::to_string(i), 1 + i % 3, {uniform(random), uniform(random), 0.3 + uniform(random)});
      if (i % 3 == 0) model.add_collider({.body = body, .solid = contact::sphere(0.05, Pose(Vec3{0.1, 0.1, 0.1}))});
    }
    model.add_collider({.plane = true});
    const Separation separation = separation_of(model);
    CAPTURE(k);
    if (separation.left) MESSAGE(separation.error()->message());
    CHECK_FALSE(separation.left.has_value());
    CHECK(separation.largest < 0.4);
    Simulation sim(model, {.method = "stepping", .resolve = true});
    CHECK(sim.run_until(0.01));
  }
}

TEST_CASE("overlaps: what can't be pushed apart is an error with the pair and the depth") {
  Model slides;
  const BodyId block = slides.add({.name = "slide/block",
                                   .mass = 1,
                                   .inertia = diagonal(0.01),
                                   .at = Pose(Vec3{0, 0, 0.095}),
                                   .joint = Prismatic{{1, 0, 0}}});
  slides.add_collider({.body = block, .solid = contact::box({0.2, 0.2, 0.2})});
  slides.add_collider({.plane = true});
  slides.add_contact_rule({.one = {block}, .other = {ground}});
  CHECK(error_of([&] { Simulation sim(slides, pushed_apart); }) ==
        "error: 'slide/block' and 'ground' can't be pushed apart: they still overlap by 0.005 m; move one of them, or let them "
        "pass through "
        "each other: [[contact]] with off = true");
  Model wedged;
  add_box(wedged, "box", 1, {0, 0, 0.1});
  wedged.add_collider({.plane = true});
  wedged.add_collider({.solid = contact::box({2, 2, 0.2}, Pose(Vec3{0, 0, 0.28}))});
  CHECK(error_of([&] { Simulation sim(wedged, pushed_apart); }).find("error: 'box' and 'ground' can't be pushed apart") == 0);
}
