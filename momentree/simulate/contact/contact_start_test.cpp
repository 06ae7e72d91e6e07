// Contacts before a run begins, and after a state was set.
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/contact/contact_test_support.hpp>

using namespace momentree;
using namespace momentree::testing;

TEST_CASE("before a run: bodies at rest are carried, and the run still begins with their events") {
  for (const char* method : {"rk4", "dopri5", "stepping"}) {
    CAPTURE(method);
    Simulation sim(boxes(3), {.method = method, .step = 1e-3});
    CHECK(sim.events().empty());
    CHECK(sim.world().contacts().size() >= 12);
    for (int k = 0; k < 3; ++k) {
      CHECK(norm(force_on(sim.world(), {k}) - Vec3{0, 0, 2 * g}) < 1e-10);
      CHECK(norm(sim.world().accelerations()[static_cast<std::size_t>(k)].linear) < 1e-10);
    }
    CHECK(sim.statistics().evaluations[0] == 0);
    REQUIRE(sim.run_until(0.01));
    if (std::string(method) == "stepping") continue;
    REQUIRE(sim.events().size() == 3);
    for (const Event& event : sim.events()) CHECK((event.name.starts_with("rest") && event.time == 0));
  }
}

TEST_CASE("before a run: bodies that slide are braked, those that fly or hit something are not") {
  Simulation sim(boxes(1));
  const auto with_velocity = [&](const Vec3& v) {
    const double q[] = {0, 0, 0.1, 1, 0, 0, 0}, u[] = {v.x, v.y, v.z, 0, 0, 0};
    sim.set_state(0, q, u, Variables::velocities);
    return sim.world().accelerations()[0].linear;
  };
  CHECK(norm(with_velocity({3, 4, 0}) - friction * g * Vec3{-0.6, -0.8, 0}) < 1e-10);
  CHECK(sim.world().contacts().size() == 4);
  CHECK(norm(with_velocity({0, 0, 1}) - Vec3{0, 0, -g}) < 1e-12);
  CHECK(norm(with_velocity({0, 0, -1}) - Vec3{0, 0, -g}) < 1e-12);
  CHECK(sim.world().contacts().empty());
  REQUIRE(sim.run_until(1e-3));
  CHECK(sim.events().front().name.starts_with("impact"));
}

TEST_CASE("before a run: forces that are set decide which contacts close") {
  Simulation sim(boxes(1));
  const auto pushed = [&](const Vec3& force) {
    sim.force("box/0", [force](const EvaluationContext&) { return Wrench{force, {}}; });
    return sim.world().accelerations()[0].linear;
  };
  CHECK(norm(pushed({0, 0, 3 * g}) - Vec3{0, 0, 0.5 * g}) < 1e-10);
  CHECK(sim.world().contacts().empty());
  CHECK(norm(pushed({1, 0, 0})) < 1e-10);
  CHECK(norm(pushed({2 * friction * g + 1, 0, 0}) - Vec3{0.5, 0, 0}) < 1e-6);
  sim.set_gravity({0, 0, g});
  CHECK(sim.world().contacts().empty());
}

TEST_CASE("before a run: actions, added bodies, snapshots and branches do not see contacts that are pending") {
  Simulation sim(boxes(2));
  Simulation other = sim.branch();
  const SimulationSnapshot start = sim.snapshot();
  static_cast<void>(sim.apply(impulse("box/1", {0, 0, 2})));
  CHECK(sim.events().front().after.kinetic == doctest::Approx(1.0).epsilon(1e-9));  // nothing but the upper box moves
  CHECK(norm(sim.world().motions()[0].linear) == 0);
  sim.restore(start);
  REQUIRE(sim.run_until(0.1));
  REQUIRE(other.run_until(0.1));
  CHECK(sim.events().size() == other.events().size());
  const std::span<const double> one = sim.world().state().q(), two = other.world().state().q();
  CHECK(std::equal(one.begin(), one.end(), two.begin()));
}
