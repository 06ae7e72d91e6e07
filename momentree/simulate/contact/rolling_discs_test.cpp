// Discs that roll on their edge: thin ellipsoids, and the rims of cylinders.
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81, m = 2, R = 0.3;

struct Disc {
  double across, axial;  // moments of inertia about the centre
  contact::Solid solid = contact::ellipsoid({R, R, 1e-6 * R});
  double half = 0;  // thickness
  Vec3 edge() const { return {0, -R, -half}; }
};
const Disc uniform{m * R * R / 4, m*R*R / 2}, hoop{m * R * R / 2, m*R*R},
    thick{m * R * R / 4, m*R*R / 2, contact::cylinder(R, 0.06), 0.03};

/// It rolls with its axis at that angle to the vertical. `spin`: in the disc's axes, of which y points upward.
Simulation on_floor(const Disc& disc, double angle, const Vec3& spin) {
  const Vec3 v = cross(disc.edge(), spin);
  Model model({.gravity = {0, 0, -g}});
  const double height = R * std::sin(angle) + disc.half * std::cos(angle);
  const BodyId body = model.add({.name = "disc",
                                 .mass = m,
                                 .inertia = diagonal(disc.across, disc.across, disc.axial),
                                 .joint = Free{},
                                 .q = {0, 0, height, std::cos(angle / 2), std::sin(angle / 2), 0, 0},
                                 .v = {v.x, v.y, v.z, spin.x, spin.y, spin.z}});
  model.add_collider({.body = body, .solid = disc.solid});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = 5, .static_friction = 5}});
  return Simulation(model, {.method = "dop853", .rtol = 1e-11, .atol = 1e-13});
}

double angle_of(const Simulation& sim) {
  const Vec3 axis = rotation_matrix(sim.world().motions()[0].pose.rotation) * Vec3{0, 0, 1};
  return std::atan2(std::hypot(axis.x, axis.y), axis.z);
}

}  // namespace

TEST_CASE("discs: one that rolls on a circle keeps its angle and its energy") {
  for (const Disc& disc : {uniform, hoop, thick})
    for (const double angle : {1.2, 0.6, 0.3})
      for (const double yaw : {1.0, 4.0}) {
        INFO(angle, " ", yaw, " ", disc.half);
        // Everything turns about the vertical: the moment of the force at the edge about the centre is yaw × angular momentum,
        // for a spin w about the axis, on which both depend linearly.
        const Vec3 up{0, std::sin(angle), std::cos(angle)}, turns = yaw * up;
        const auto missing = [&](double w) {
          const Vec3 spin{0, turns.y, w}, force = m * cross(turns, cross(disc.edge(), spin)) + m * g * up;
          return (cross(turns, Vec3{0, disc.across * spin.y, disc.axial * w}) - cross(disc.edge(), force)).x;
        };
        const double w = missing(0) / (missing(0) - missing(1));
        Simulation sim = on_floor(disc, angle, {0, turns.y, w});
        for (int k = 1; k <= 10; ++k) {
          const RunResult run = sim.run_until(0.5 * k);
          INFO(run.reason);
          REQUIRE(run);
          CHECK(std::fabs(angle_of(sim) - angle) < 1e-9);
          CHECK(std::fabs(sim.world().motions()[0].angular.z - (turns.y * up.y + w * up.z)) < 1e-9);
        }
        CHECK(sim.events().size() == 1);  // it rests
        CHECK(std::fabs(sim.energy().error) < 1e-11 * sim.world().totals().kinetic);
      }
}

TEST_CASE("discs: an upright one falls below the speed at which A m g R = C (C + m R²) w², and not above") {
  constexpr double leans = 1e-6;
  for (const Disc& disc : {uniform, hoop}) {
    const double A = disc.across, C = disc.axial, moment = m * R * R;
    const double critical = std::sqrt(A * m * g * R / (C * (C + moment)));
    CHECK(critical == doctest::Approx(std::sqrt(g / ((C == moment ? 4 : 3) * R))));
    for (const double share : {0.9, 0.99, 1.01, 1.5}) {
      CAPTURE(share);
      const double w = share * critical;
      Simulation sim = on_floor(disc, std::numbers::pi / 2 + leans, {0, 0, w});
      // (A + m R²) a″ = m g R a − (C + m R²) C w² (a − a₀)/A: of the yaw that leaning causes, A yaw = C w (a − a₀).
      const double righting = (C + moment) * C * w * w / A, middle = leans * righting / (righting - m * g * R);
      const double square = (m * g * R - righting) / (A + moment), rate = std::sqrt(std::fabs(square));
      CHECK((square > 0) == (share < 1));
      for (const double t : {0.5, 1.0, 1.5, 2.0}) {
        REQUIRE(sim.run_until(t));
        const double expected = middle + (leans - middle) * (square > 0 ? std::cosh(rate * t) : std::cos(rate * t));
        CHECK(std::fabs(angle_of(sim) - std::numbers::pi / 2 - expected) < 1e-5 * std::fabs(expected) + 1e-12);
      }
    }
  }
}
