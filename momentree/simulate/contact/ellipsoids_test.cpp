// Ellipsoids that rock, roll and land: closed forms and conservation laws, located and stepped through.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81, mass = 2;
constexpr Vec3 axes{0.3, 0.2, 0.1};  // m

BodySpec body(const Vec3& at, const Quat& turned = {}) {
  const Vec3 s{axes.x * axes.x, axes.y * axes.y, axes.z * axes.z};
  return {.name = "egg/egg",
          .mass = mass,
          .inertia = diagonal(mass * (s.y + s.z) / 5, mass * (s.z + s.x) / 5, mass * (s.x + s.y) / 5),
          .joint = Free{},
          .q = {at.x, at.y, at.z, turned.w, turned.x, turned.y, turned.z}};
}

Model on_floor(const BodySpec& spec, double friction, double restitution = 0, bool plate = false) {
  Model model({.gravity = {0, 0, -g}});
  const BodyId egg = model.add(spec);
  model.add_collider({.body = egg, .solid = contact::ellipsoid(axes)});
  if (plate) {
    const BodyId fixed =
        model.add({.name = "plate/plate", .mass = 1, .inertia = diagonal(1), .at = {0, 0, -0.1}, .joint = Weld{}});
    model.add_collider({.body = fixed, .solid = contact::box({4, 4, 0.2})});
  } else {
    model.add_collider({.plane = true});
  }
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction, .restitution = restitution}});
  return model;
}

double height(double angle) {  // of the centre above a floor, turned about y
  return std::hypot(axes.z * std::cos(angle), axes.x * std::sin(angle));
}

}  // namespace

TEST_CASE("ellipsoids: one that rolls on a floor rocks with the frequency of its curvature") {
  // Without slip about y: ω² = m g (ρ − c)/(I + m c²), where ρ = a²/c is the radius of curvature at the lowest point.
  const double a = axes.x, c = axes.z, I = mass * (a * a + c * c) / 5;
  const double period = 2 * std::numbers::pi / std::sqrt(mass * g * (a * a / c - c) / (I + mass * c * c));
  const double angle = 1e-4;
  Model model = on_floor(body({0, 0, height(angle)}, from_axis_angle({0, 1, 0}, angle)), 1);
  Simulation sim(model, {.method = "dop853", .rtol = 1e-12, .atol = 1e-14});
  REQUIRE(sim.run_until(0.75 * period));
  // A quarter of a period after the turning point it is upright, to the third order of the angle.
  const double rate = sim.world().motions()[0].angular.y;
  CHECK(std::fabs(std::fabs(rate) - angle * 2 * std::numbers::pi / period) < 1e-6 * angle * 2 * std::numbers::pi / period + 1e-9);
  CHECK(std::fabs(log_rotation(sim.world().motions()[0].pose.rotation).y) < 1e-6 * angle + 1e-10);
  CHECK(std::fabs(sim.energy().error) < 1e-13);
}

TEST_CASE("ellipsoids: rolling without slip conserves energy, and the contact does not slip") {
  const Quat turned = from_rpy(0.3, 0.6, 0);
  const Vec3 up = transpose_times(rotation_matrix(turned), Vec3{0, 0, 1});
  Simulation sim(on_floor(body({0, 0, norm(Vec3{axes.x * up.x, axes.y * up.y, axes.z * up.z})}, turned), 3),
                 {.method = "dop853", .rtol = 1e-11, .atol = 1e-13});
  const auto energy = [&] { return sim.world().totals().kinetic + sim.world().totals().potential; };
  const double before = energy();
  double fastest = 0;
  for (int k = 1; k < 20; ++k) {
    const RunResult run = sim.run_until(0.1 * k);
    INFO(run.reason);
    REQUIRE(run);
    REQUIRE(sim.world().contacts().size() == 1);
    CHECK_FALSE(sim.world().contacts()[0].slips);
    CHECK(norm(sim.world().contacts()[0].slip) < 1e-10);
    CHECK(std::fabs(energy() - before) < 1e-9);
    CHECK(std::fabs(sim.world().gap(BodyId{0}, ground)->distance) < 1e-12);
    fastest = std::max(fastest, norm(sim.world().motions()[0].angular));
  }
  CHECK(fastest > 1);
  CHECK(sim.events().size() == 1);
}

TEST_CASE("ellipsoids: one that lands without friction rebounds as impulse and momentum say") {
  const double angle = 0.5, e = 0.6;
  Model model = on_floor(body({0, 0, height(angle) + 0.2}, from_axis_angle({0, 1, 0}, angle)), 0, e);
  Simulation sim(model, {.method = "dop853", .rtol = 1e-11, .atol = 1e-13});
  REQUIRE(sim.run_until(std::sqrt(2 * 0.2 / g) + 1e-3));
  const double v = std::sqrt(2 * g * 0.2), h = height(angle), I = mass * (axes.x * axes.x + axes.z * axes.z) / 5;
  const double arm = (axes.x * axes.x - axes.z * axes.z) * std::sin(angle) * std::cos(angle) / h;
  const double impulse = (1 + e) * v / (1 / mass + arm * arm / I);
  REQUIRE_FALSE(sim.events().empty());
  CHECK(std::fabs(sim.events()[0].time - std::sqrt(2 * 0.2 / g)) < 1e-9);
  CHECK(norm(sim.events()[0].contact.impulse - Vec3{0, 0, impulse}) < 1e-8);
}

TEST_CASE("ellipsoids: stepped through, one comes to rest on its flattest side, and gains no energy") {
  for (const char* const method : {"stepping", "dop853"}) {
    CAPTURE(method);
    const BodySpec spec = body({0, 0, 0.5}, from_axis_angle(normalized(Vec3{1, 2, 0}), 0.9));
    const Model model = on_floor(spec, 0.5, 0, true);
    Simulation sim(model, {.method = method, .step = 1e-3});
    const RunResult run = sim.run_until(method == std::string("stepping") ? 6 : 1);
    INFO(run.reason);
    REQUIRE(run);
    const EnergyBalance balance = sim.energy();
    CHECK(balance.final < balance.initial);
    CHECK(std::fabs(balance.error) < 1e-2 * balance.largest_kinetic);
    CHECK(sim.world().gap(BodyId{0}, BodyId{1})->distance > -1e-4);
  }
}
