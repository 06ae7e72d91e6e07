// Orders of convergence through impacts and through stick and slip, and bodies so fast that a step takes them through a plate.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

/// A box that is thrown, bounces without friction, and turns: its motion is smooth between impacts, and never closed.
Model bouncing_box() {
  Model model;
  const BodyId box = model.add({.name = "box",
                                .mass = 2,
                                .inertia = diagonal(0.03, 0.04, 0.05),
                                .joint = Free{},
                                .q = {0, 0, 0.6, 1, 0, 0, 0},
                                .v = {1, 0, 0, 2, 3, -1}});
  model.add_collider({.body = box, .solid = contact::box({0.4, 0.3, 0.2})});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = 0, .static_friction = 0, .restitution = 0.9}});
  return model;
}

struct Bounced {
  Vec3 position;
  int impacts = 0;
};
Bounced bounce(const std::string& method, double step) {
  Simulation sim(bouncing_box(), {.method = method, .step = step, .rtol = 1e-13, .atol = 1e-14});
  const RunResult run = sim.run_until(1.5);
  INFO(run.reason);
  REQUIRE(run);
  Bounced all{sim.world().motions()[0].pose.position};
  for (const Event& event : sim.events()) all.impacts += event.name == "impact" ? 1 : 0;
  return all;
}

constexpr double stiffness = 40, mass = 1.5, pull = 0.2, mu_static = 0.6, mu = 0.35, g = 9.81;

/// A block on the floor, pulled by a spring whose other end moves at a constant speed.
std::vector<double> slips_of_pulled_block(const std::string& method, double step, double until) {
  Model model({.gravity = {0, 0, -g}});
  const BodyId block =
      model.add({.name = "block", .mass = mass, .inertia = diagonal(0.1), .joint = Free{}, .q = {0, 0, 0.02, 1, 0, 0, 0}});
  const BodyId cart = model.add({.name = "cart",
                                 .mass = 1,
                                 .inertia = diagonal(0.1),
                                 .at = {2, 0, 0.02},
                                 .joint = Prismatic{.axis = {1, 0, 0}, .drive = motion_drive(Signal::ramp(pull, 0))}});
  model.add_collider({.body = block, .solid = contact::box({0.4, 0.4, 0.04})});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = mu, .static_friction = mu_static}});
  model.add_spring({.name = "spring", .from = {block, {}}, .to = {cart, {}}, .stiffness = stiffness, .rest = 2});
  Simulation sim(model, {.method = method, .step = step, .rtol = 1e-13, .atol = 1e-15});
  const RunResult run = sim.run_until(until);
  INFO(run.reason);
  REQUIRE(run);
  std::vector<double> slips;
  for (const Event& event : sim.events())
    if (event.name == "slip") slips.push_back(event.time);
  return slips;
}

/// The order that errors with steps h, h/2 and h/4 show.
void check_order(const std::vector<double>& errors, double order) {
  CAPTURE(errors[0]);
  CAPTURE(errors[1]);
  CAPTURE(errors[2]);
  CHECK(0.5 * std::log2(errors[0] / errors[2]) > order - 0.5);
}

}  // namespace

TEST_CASE("contact accuracy: rk4 keeps its order through impacts") {
  const Bounced exact = bounce("dop853", 1e-2);
  CHECK(exact.impacts >= 4);
  std::vector<double> errors;
  for (const double step : {8e-3, 4e-3, 2e-3}) {
    const Bounced now = bounce("rk4", step);
    errors.push_back(norm(now.position - exact.position));
    CHECK(now.impacts == exact.impacts);
  }
  check_order(errors, 4);
}

TEST_CASE("contact accuracy: a block that sticks and slips does so at the instants of the closed form, with the order of rk4") {
  const double omega = std::sqrt(stiffness / mass), drop = (mu_static - mu) * mass * g / stiffness;
  const double slipping = 2 / omega * (std::numbers::pi - std::atan(drop * omega / pull));
  const double first = mu_static * mass * g / stiffness / pull, period = 2 * drop / pull + slipping;
  const double until = first + 3.5 * period;
  const std::vector<double> exact = slips_of_pulled_block("dop853", 1e-2, until);
  REQUIRE(exact.size() == 4);
  for (std::size_t k = 0; k < 4; ++k) CHECK(std::fabs(exact[k] - first - static_cast<double>(k) * period) < 1e-8);
  std::vector<double> errors;
  for (const double step : {0.04, 0.02, 0.01}) {
    const std::vector<double> slips = slips_of_pulled_block("rk4", step, until);
    REQUIRE(slips.size() == 4);
    errors.push_back(std::fabs(slips[3] - first - 3 * period));
  }
  check_order(errors, 4);
}

TEST_CASE("contact accuracy: bodies at 1 km/s do not pass through a plate of a millimetre") {
  const contact::Solid solids[] = {contact::sphere(0.01), contact::capsule(0.01, 0.03), contact::cylinder(0.01, 0.03),
                                   contact::box({0.02, 0.03, 0.01})};
  for (const contact::Solid& solid : solids)
    for (const char* method : {"rk4", "dopri5", "dop853", "stepping"}) {
      Model model({.gravity = {}});
      const BodyId shot = model.add({.name = "shot",
                                     .mass = 0.05,
                                     .inertia = diagonal(1e-5),
                                     .joint = Free{},
                                     .q = {0.01, 0, 10, 1, 0, 0, 0},
                                     .v = {0, 0, -1000, 0, 0, 0}});
      const BodyId plate = model.add({.name = "plate", .mass = 1, .inertia = diagonal(1), .joint = Weld{}});
      model.add_collider({.body = shot, .solid = solid});
      model.add_collider({.body = plate, .solid = contact::box({2, 2, 0.001})});
      model.add_contact_rule({.law = {.friction = 0, .static_friction = 0, .restitution = 0.5}});
      Simulation sim(model, {.method = method, .step = 1e-3});
      CAPTURE(method);
      const RunResult run = sim.run_until(0.02);
      INFO(run.reason);
      REQUIRE(run);
      const BodyMotion& motion = sim.world().motions()[0];
      CHECK(motion.pose.position.z > 0);
      CHECK(motion.linear.z > 0);
      CHECK(motion.linear.z < 1000);
    }
}
