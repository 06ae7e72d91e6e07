// Bodies that land, bounce, slip, stick, roll, rock and pile up. (The law of impact alone: contact/impact_test.cpp.)
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/simulate/stepping/overlap.hpp>
#include <tests/error_of.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;

namespace {

const Event* first(const Simulation& sim, const std::string& name) {
  const auto found = std::find_if(sim.events().begin(), sim.events().end(), [&](const Event& e) { return e.name == name; });
  return found == sim.events().end() ? nullptr : &*found;
}

Model ball_above_floor(double restitution, double friction, Values v = {}) {
  Model model;
  const BodyId ball = model.add({.name = "ball/ball",
                                 .mass = 2,
                                 .inertia = diagonal(0.4 * 2 * 0.01),
                                 .joint = Free{},
                                 .q = {0, 0, v.empty() ? 1.1 : 0.1, 1, 0, 0, 0},
                                 .v = std::move(v)});
  model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction, .restitution = restitution}});
  return model;
}

double height(const Simulation& sim, int body = 0) {
  return sim.world().motions()[static_cast<std::size_t>(body)].pose.position.z;
}

}  // namespace

TEST_CASE("contact: a ball bounces at the instants of the closed form and comes to rest at their limit") {
  for (const char* method : {"rk4", "dopri5", "dop853"}) {
    Simulation sim(ball_above_floor(0.8, 0), {.method = method, .step = 1e-2});
    REQUIRE(sim.run_until(5));
    const double t1 = std::sqrt(2 / 9.81);
    double time = t1, speed = 9.81 * t1;
    for (std::size_t k = 0; k < 30; ++k) {
      const Event& event = sim.events()[k];
      REQUIRE(event.name == "impact");
      CHECK(std::fabs(event.time - time) < 1e-9);
      CHECK(event.contact.impulse.z == doctest::Approx(2 * 1.8 * speed).epsilon(1e-8));
      speed *= 0.8, time += 2 * speed / 9.81;
    }
    REQUIRE(sim.events().back().name == "rest");
    CHECK(std::fabs(sim.events().back().time - 9 * t1) < 1e-9);
    CHECK(std::fabs(height(sim) - 0.1) < 1e-15);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
  }
}

TEST_CASE("contact: a ball that slips ends up rolling with 5/7 of its speed") {
  Simulation sim(ball_above_floor(0, 0.2, {1, 0, 0, 0, 0, 0}), {.method = "dop853", .step = 1e-2, .rtol = 1e-13, .atol = 1e-15});
  REQUIRE(sim.run_until(1));
  REQUIRE(first(sim, "slip") != nullptr);
  const Event* const stick = first(sim, "stick");
  REQUIRE(stick != nullptr);
  CHECK(std::fabs(stick->time - 2.0 / (7 * 0.2 * 9.81)) < 1e-9);
  CHECK(std::fabs(sim.world().motions()[0].linear.x - 5.0 / 7) < 1e-10);
  CHECK(std::fabs(sim.energy().dissipated - (0.5 * 2 - 0.7 * 2 * 25.0 / 49)) < 1e-9);
}

TEST_CASE("contact: a block on an incline stops, or slips on") {
  struct Case {
    double mu, speed, stop, x;  // stop: infinite if it slips on; x: where it is after 2 s
  };
  const double a = 20 * std::numbers::pi / 180, downhill = 9.81 * (std::sin(a) - 0.2 * std::cos(a));
  for (const Case& c : {Case{0.5, 2, 1.5949285114815006, 1.5949285114815006},
                        {0.5, -3, 0.3766757403915407, -0.565013610587311},
                        {0.2, 2, HUGE_VAL, 4 + 2 * downhill}}) {
    Model model;
    const BodyId block = model.add({.name = "block/block",
                                    .mass = 2,
                                    .inertia = diagonal(0.1, 0.2, 0.25),
                                    .joint = Free{},
                                    .q = {0, 0, 0, std::cos(a / 2), 0, std::sin(a / 2), 0},
                                    .v = {c.speed, 0, 0, 0, 0, 0}});
    model.add_collider({.body = block, .solid = contact::box({1, 0.8, 0.1})});
    const Vec3 normal{std::sin(a), 0, std::cos(a)};
    model.add_collider({.plane = true, .point = -0.05 * normal, .normal = normal});
    model.add_contact_rule({.law = {.friction = c.mu, .static_friction = c.mu}});
    Simulation sim(model, {.step = 1e-2});
    REQUIRE(sim.run_until(2));
    const Event* const stick = first(sim, "stick");
    REQUIRE((stick != nullptr) == std::isfinite(c.stop));
    if (stick != nullptr) CHECK(std::fabs(stick->time - c.stop) < 1e-9);
    const Vec3 at = sim.world().motions()[0].pose.position;
    CHECK(std::fabs(dot(at, Vec3{std::cos(a), 0, -std::sin(a)}) - c.x) < 1e-9);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
  }
}

TEST_CASE("contact: slip that stops and turns back in one instant begins anew") {
  const double a = 20 * std::numbers::pi / 180, up = 9.81 * (std::sin(a) + 0.2 * std::cos(a)), turn = 3 / up;
  for (const char* method : {"rk4", "dopri5", "dop853"}) {
    CAPTURE(method);
    Model model({.gravity = {9.81 * std::sin(a), 0, -9.81 * std::cos(a)}});  // too steep for the block to stay
    const BodyId block = model.add({.name = "block/block",
                                    .mass = 2,
                                    .inertia = diagonal(0.1, 0.2, 0.25),
                                    .joint = Free{},
                                    .q = {0, 0, 0.05, 1, 0, 0, 0},
                                    .v = {-3, 0, 0, 0, 0, 0}});
    model.add_collider({.body = block, .solid = contact::box({1, 0.8, 0.1})});
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = 0.2, .static_friction = 0.2}});
    Simulation sim(model, {.method = method, .step = 1e-2});
    int turned = 0;
    REQUIRE(sim.run_until(1.5));
    for (const Event& event : sim.events())
      if (event.name == "slip" && event.time > 0) {
        ++turned;
        CHECK(std::fabs(event.time - turn) < 1e-9);
      }
    CHECK(turned == 1);
    CHECK(first(sim, "stick") == nullptr);
    const double down = 9.81 * (std::sin(a) - 0.2 * std::cos(a)), since = 1.5 - turn;
    CHECK(std::fabs(sim.world().motions()[0].linear.x - down * since) < 1e-8);
  }
}

TEST_CASE("contact: slip that swings to and fro on an arc turns back every half period") {
  for (const char* method : {"rk4", "dop853"}) {
    CAPTURE(method);
    Model model({.gravity = {0, 0, -9.81}});
    const BodyId arm = model.add({.name = "arm",
                                  .mass = 1,
                                  .com = {1, 0, 0},
                                  .inertia = diagonal(0.01),
                                  .joint = Cylindrical{.axis = {0, 0, 1}, .stiffness = {20, 0}},
                                  .q = {2.0, 0.1}});
    model.add_collider({.body = arm, .solid = contact::sphere(0.1, Pose(Vec3{1, 0, 0}))});
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = 0.1, .static_friction = 0.1}});
    Simulation sim(model, {.method = method, .step = 1e-3});
    const double half = std::numbers::pi * std::sqrt(1.01 / 20);
    REQUIRE(sim.run_until(3.5 * half));
    std::vector<double> turns;
    for (const Event& event : sim.events())
      if (event.name == "slip" && event.time > 0) turns.push_back(event.time);
    REQUIRE(turns.size() == 3);
    for (std::size_t k = 0; k < 3; ++k) CHECK(std::fabs(turns[k] - static_cast<double>(k + 1) * half) < 1e-7);
    // Each swing is shorter by twice the angle at which the spring holds against friction.
    const double shift = 0.1 * 9.81 / 20;
    CHECK(std::fabs(sim.world().joint({0}).q[0] + shift) < 1e-5);
  }
}

TEST_CASE("contact: a rimless wheel rolls down with the speeds and the period of its limit cycle") {
  const int n = 10;
  const double L = 0.8, J = 0.3, slope = 0.06, a = std::numbers::pi / n, g = 9.81;
  Model model({.gravity = {g * std::sin(slope), 0, -g * std::cos(slope)}});
  const BodyId wheel = model.add({.name = "wheel/wheel",
                                  .mass = 1,
                                  .inertia = diagonal(1, 1, J * L * L),
                                  .at = Pose(Vec3{}, from_rpy(std::numbers::pi / 2, 0, 0)),
                                  .joint = Planar{},
                                  .q = {0, L * std::cos(a), 0},
                                  .v = {1.3, 0, -1.3 / (L * std::cos(a))}});
  for (int k = 0; k < n; ++k)
    model.add_collider(
        {.body = wheel,
         .solid = contact::sphere(1e-12, Pose(Vec3{L * std::sin(a + 2 * a * k), -L * std::cos(a + 2 * a * k), 0}))});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = 100, .static_friction = 100}});
  Simulation sim(model, {.method = "dop853", .step = 1e-2, .rtol = 1e-12, .atol = 1e-14});
  REQUIRE(sim.run_until(25));
  double last = 0, period = 0;
  for (const Event& event : sim.events())
    if (event.name == "impact") period = event.time - last, last = event.time;
  CHECK(std::fabs(period - 0.5034171848503962) < 1e-7);
  CHECK(std::fabs(sim.energy().error) < 1e-8);
}

TEST_CASE("contact: boxes fall on each other, and the pile is at rest") {
  Model model;
  for (int i = 0; i < 3; ++i) {
    const BodyId box = model.add({.name = "b" + std::to_string(i) + "/box",
                                  .mass = 1,
                                  .inertia = diagonal(1.0 / 6),
                                  .joint = Free{},
                                  .q = {0.01 * i, 0, 0.55 + 1.1 * i, 1, 0, 0, 0}});
    model.add_collider({.body = box, .solid = contact::box({1, 1, 1})});
  }
  model.add_collider({.plane = true});
  Simulation sim(model, {.step = 5e-3});
  REQUIRE(sim.run_until(0.5));
  for (int i = 0; i < 3; ++i) {
    CHECK(std::fabs(height(sim, i) - (0.5 + i)) < 1e-11);
    CHECK(norm(sim.world().motions()[static_cast<std::size_t>(i)].linear) < 1e-12);
  }
}

TEST_CASE("contact: boxes thrown on the floor never gain energy, never sink in, and conserve momentum") {
  oracle::Prng random(11);
  int impacts = 0;
  for (int k = 0; k < 20; ++k) {
    Values v;
    for (int i = 0; i < 6; ++i) v.push_back(random.uniform(-3, 3));
    const Quat r = random.rotation();
    Model model;
    const BodyId box = model.add({.name = "box/box",
                                  .mass = 2,
                                  .inertia = diagonal(0.03, 0.04, 0.05),
                                  .joint = Free{},
                                  .q = {0, 0, 1, r.w, r.x, r.y, r.z},
                                  .v = v});
    model.add_collider({.body = box, .solid = contact::box({0.4, 0.3, 0.2})});
    model.add_collider({.plane = true});
    const double mu = random.uniform(0, 1);
    model.add_contact_rule({.law = {.friction = mu, .static_friction = mu, .restitution = random.uniform(0, 0.7)}});
    Simulation sim(model, {.method = "dop853", .step = 1e-2, .rtol = 1e-10, .atol = 1e-12});
    double lowest = 1;
    sim.watch([&](double) {
      const Pose pose = sim.world().motions()[0].pose;
      for (const Vec3& corner : contact::box({0.4, 0.3, 0.2}).vertices) lowest = std::min(lowest, (pose * corner).z);
      return true;
    });
    REQUIRE(sim.run_until(0.9));
    CHECK(lowest > -1e-9);
    for (const Event& event : sim.events()) {
      impacts += event.name == "impact" ? 1 : 0;
      CHECK(event.lost > -1e-11);
      const std::array<double, 6>& G = event.ground_impulse;
      CHECK(norm(event.after.linear - event.before.linear - Vec3{G[0], G[1], G[2]}) < 1e-13);
      CHECK(norm(event.after.angular - event.before.angular - Vec3{G[3], G[4], G[5]}) < 1e-13);
    }
    CHECK(std::fabs(sim.energy().error) < 1e-6);
  }
  CHECK(impacts > 100);
}

TEST_CASE("contact: Newton's cradle, together and in turn") {
  for (const bool in_turn : {false, true}) {
    Model model({.gravity = {}});
    for (int i = 0; i < 3; ++i) {
      const BodyId ball = model.add({.name = "b" + std::to_string(i) + "/ball",
                                     .mass = 1,
                                     .inertia = diagonal(1),
                                     .joint = Prismatic{.axis = {1, 0, 0}},
                                     .q = i == 0 ? -0.5 : 0.2 * i,
                                     .v = i == 0 ? 1.0 : 0.0});
      model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
    }
    model.add_contact_rule({.law = {.friction = 0, .static_friction = 0, .restitution = 1}});
    Simulation sim(model, {.simultaneous = in_turn ? contact::Simultaneous::in_turn : contact::Simultaneous::together});
    REQUIRE(sim.run_until(0.8));
    const std::vector<double> expected = in_turn ? std::vector<double>{0, 0, 1} : std::vector<double>{-1.0 / 3, 2.0 / 3, 2.0 / 3};
    for (std::size_t i = 0; i < 3; ++i) CHECK(std::fabs(sim.world().motions()[i].linear.x - expected[i]) < 1e-12);
    CHECK(std::fabs(sim.energy().error) < 1e-12);
  }
}

TEST_CASE("contact: a run that is restored from within continues to the bit") {
  const auto make = [] { return Simulation(ball_above_floor(0.5, 0.3), {.method = "dop853", .step = 1e-2}); };
  Simulation half = make();
  REQUIRE(half.run_until(1.1));
  const SimulationSnapshot snapshot = half.snapshot();
  REQUIRE(half.run_until(1.3));
  half.restore(snapshot);
  REQUIRE(half.run_until(1.4));
  Simulation third = make();
  REQUIRE(third.run_until(1.1));
  REQUIRE(third.run_until(1.4));
  CHECK(std::equal(half.world().state().q().begin(), half.world().state().q().end(), third.world().state().q().begin()));
}

TEST_CASE("contact: mistakes are refused") {
  Model model;
  const BodyId one = model.add({.name = "a/a", .mass = 1, .inertia = diagonal(1), .joint = Free{}});
  CHECK(!error_of([&] { model.add_collider({.body = one, .plane = true}); }).empty());
  CHECK(!error_of([&] { model.add_collider({.body = one, .solid = contact::sphere(0)}); }).empty());
  CHECK(!error_of([&] { model.add_collider({.body = {7}, .solid = contact::sphere(1)}); }).empty());
  CHECK(!error_of([&] { model.add_contact_rule({.law = {.friction = -1}}); }).empty());
  CHECK(!error_of([&] { model.add_contact_rule({.law = {.restitution = 1.1}}); }).empty());
  CHECK(!error_of([&] { model.add_contact_rule({.law = {.friction = 0.5, .static_friction = 0.4}}); }).empty());
  model.add_collider({.body = one, .solid = contact::sphere(0.5)});
  CHECK(!deepest_overlap(model).has_value());
  model.add_collider({.plane = true});
  const auto overlap = deepest_overlap(model);
  REQUIRE(overlap.has_value());
  CHECK(overlap->depth == doctest::Approx(0.5));
  for (const char* method : {"damped", "midpoint"}) CHECK(!error_of([&] { Simulation(model, {.method = method}); }).empty());
  Simulation sunk(model);
  const RunResult result = sunk.run_until(0.1);
  CHECK(result.status == Status::stalled);
  CHECK(result.reason.find("'a/a' and 'ground' overlap by 0.5 m") != std::string::npos);
}

TEST_CASE("contact: a thrown box comes to rest at the same place with every method") {
  for (const char* method : {"rk4", "dopri5", "dop853"}) {
    Model model;
    const BodyId box = model.add({.name = "box/box",
                                  .mass = 2,
                                  .inertia = diagonal(0.03, 0.04, 0.05),
                                  .joint = Free{},
                                  .q = {0, 0, 1, 1, 0, 0, 0},
                                  .v = {1, 0, 0, 2, 3, -1}});
    model.add_collider({.body = box, .solid = contact::box({0.4, 0.3, 0.2})});
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = 0.4, .static_friction = 0.4, .restitution = 0.3}});
    Simulation sim(model, {.method = method, .step = 1e-3});
    const RunResult run = sim.run_until(1.5);
    CAPTURE(method);
    INFO(run.reason);
    REQUIRE(run);
    const BodyMotion& end = sim.world().motions()[0];
    CHECK(norm(end.pose.position - Vec3{1.0999855, 0.0341492, 0.15}) < 1e-6);
    CHECK(norm(end.linear) + norm(end.angular) < 1e-12);
  }
}

TEST_CASE("contact: a force that grows sets a block in motion at the instant, in its own direction") {
  for (const char* method : {"rk4", "dop853"}) {
    Model model;
    const BodyId block =
        model.add({.name = "block/block", .mass = 2, .inertia = diagonal(0.0133), .joint = Free{}, .q = {0, 0, 0.1, 1, 0, 0, 0}});
    model.add_collider({.body = block, .solid = contact::box({0.2, 0.2, 0.2})});
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = 0.3, .static_friction = 0.3}});
    Simulation sim(model, {.method = method});
    sim.force("block/block", [](const EvaluationContext& now) { return Wrench{{8 * std::sin(3 * now.time()), 0, 0}, {}}; });
    REQUIRE(sim.run_until(0.8));
    const double t0 = std::asin(0.3 * 2 * 9.81 / 8) / 3;
    REQUIRE(sim.events().size() >= 2);
    CHECK(sim.events()[0].name == "rest");
    CHECK(sim.events()[1].name == "slip");
    CHECK(first(sim, "stepping") == nullptr);
    CHECK(std::fabs(sim.events()[1].time - t0) < 5e-7);
    const Vec3 v = sim.world().motions()[0].linear;
    CHECK(v.x == doctest::Approx(4.0 / 3 * (std::cos(3 * t0) - std::cos(2.4)) - 0.3 * 9.81 * (0.8 - t0)).epsilon(1e-5));
    CHECK(std::fabs(v.y) < 1e-5);
  }
}

TEST_CASE("contact: what a prescribed motion does in an impact is work, and the impact loses energy") {
  for (const double e : {0.0, 0.5, 1.0}) {
    constexpr double mass = 2, height = 0.3, omega = 2 * std::numbers::pi;
    Model model({.gravity = {0, 0, 0}});
    const BodyId plate = model.add({.name = "plate",
                                    .mass = 5,
                                    .inertia = diagonal(0.1),
                                    .joint = Prismatic{.axis = {0, 0, 1}, .drive = motion_drive(Signal::sine(0.5, 1))}});
    const BodyId ball = model.add(
        {.name = "ball", .mass = mass, .inertia = diagonal(0.01), .joint = Free{}, .q = {0, 0, height + 0.15, 1, 0, 0, 0}});
    model.add_collider({.body = plate, .solid = contact::box({0.8, 0.8, 0.1})});
    model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
    model.add_contact_rule({.law = {.restitution = e}});
    Simulation sim(model, {.method = "dop853"});
    REQUIRE(sim.run_until(0.2) == Status::ok);
    const Event* const hit = first(sim, "impact");
    REQUIRE(hit != nullptr);
    const double v = 0.5 * omega * std::cos(omega * hit->time);
    CHECK(hit->lost == doctest::Approx(0.5 * mass * v * v * (1 - e * e)));
    CHECK(hit->work == doctest::Approx((1 + e) * mass * v * v));
    CHECK(std::fabs(sim.energy().error) < 1e-8);
  }
}

TEST_CASE("contact: bodies that are welded together do not touch until the weld breaks") {
  for (const char* method : {"dop853", "stepping"}) {
    Model model;
    const auto wall = [&](const char* name, const Vec3& at, const Vec3& size) {
      const BodyId body = model.add({.name = name, .mass = 1, .inertia = diagonal(0.1), .at = {at}});
      model.add_collider({.body = body, .solid = contact::box(size)});
      return body;
    };
    wall("one/w", {0, 0, 0.45}, {2, 0.1, 1});  // in the floor and in each other
    const BodyId other = wall("other/w", {1, 1, 0.5}, {0.1, 2.1, 1});
    const BodyId shelf =
        model.add({.name = "other/shelf", .mass = 1, .inertia = diagonal(0.01), .parent = other, .at = {{-0.1, 0, 0}}});
    model.add_collider({.body = shelf, .solid = contact::box({0.1, 0.2, 0.1})});
    model.add_collider({.plane = true});
    Simulation sim(model, {.method = method, .step = 1e-3});
    sim.at(0.1).then(break_joint("other/shelf"));
    REQUIRE(sim.run_until(0.1));
    CHECK(sim.world().contacts().empty());
    REQUIRE(sim.run_until(2));
    CHECK(height(sim, shelf.index) == doctest::Approx(0.05).epsilon(1e-9));  // it slides down along the wall
    const std::vector<ContactPoint> points = sim.world().contacts();         // also along the wall
    CHECK(std::ranges::count(points, ground, &ContactPoint::other) == 4);
  }
}

TEST_CASE("contact: a pair of bodies has one order, whichever features touch") {
  Model model({.gravity = {}});
  BodyId boxes[2];
  for (const int i : {0, 1}) {
    boxes[i] = model.add(
        {.name = i == 0 ? "a" : "b", .mass = 1, .inertia = diagonal(0.01), .joint = Free{}, .q = {0.2 * i, 0, 0, 1, 0, 0, 0}});
    model.add_collider({.body = boxes[i], .solid = contact::box({0.2, 0.2, 0.2})});
  }
  Simulation sim(model, {.method = "dop853"});
  for (const int i : {0, 1})
    sim.force(i == 0 ? "a" : "b", [i](const EvaluationContext&) { return Wrench{{i == 0 ? 7.0 : -7.0, 0, 0}, {}}; });
  REQUIRE(sim.run_until(0.5));
  Vec3 sum{};
  for (const ContactPoint& point : sim.world().contacts()) {
    CHECK((point.one == boxes[0] && point.other == boxes[1]));
    sum += point.force;
  }
  CHECK(norm(sum - Vec3{-7, 0, 0}) < 1e-9);
}
