// Joints that break under their own loads: which ones break, and when, must not depend on the method or its steps.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

// A chain that swings from a horizontal position, with successively weaker links.
std::vector<Event> breaks(const Integration& integration) {
  Model model;
  BodyId last = ground;
  for (int k = 1; k <= 8; ++k)
    last = model.add({.name = "c/" + std::to_string(k),
                      .mass = 0.5,
                      .com = {0.15, 0, 0},
                      .inertia = diagonal(1e-4, 4e-3, 4e-3),
                      .parent = last,
                      .at = {k == 1 ? 0.0 : 0.3, 0, 0},
                      .joint = Revolute{.axis = {0, 1, 0}, .damping = 0.01},
                      .q = 0.05 * k});
  Simulation sim(model, integration);
  const double strength[8] = {60, 44, 35, 27, 21, 15, 9.5, 4.2};
  for (int k = 1; k <= 8; ++k) {
    const std::string joint = "c/" + std::to_string(k);
    sim.when(reaction_force(joint).exceeds(strength[k - 1])).then(break_joint(joint));
  }
  REQUIRE(sim.run_until(1.5) == Status::ok);
  return sim.events();
}

}  // namespace

TEST_CASE("a chain whose joints break by tension: the same joints at the same instants by every method") {
  const std::vector<Event> exact = breaks({.method = "dopri5", .rtol = 1e-11, .atol = 1e-13});
  REQUIRE(exact.size() >= 3);
  for (const Integration& how : {Integration{.method = "rk4", .step = 1e-4}, Integration{.method = "dop853", .rtol = 1e-10}}) {
    const std::vector<Event> found = breaks(how);
    REQUIRE(found.size() == exact.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
      CHECK(found[i].actions == exact[i].actions);
      CHECK(std::fabs(found[i].time - exact[i].time) < 1e-7);
    }
  }
  double last = 0;
  for (const Event& e : exact) {
    CHECK(e.time >= last);
    last = e.time;
  }
}

TEST_CASE("global order through an event that waits for a condition") {
  // A pendulum whose revolute joint becomes a ball joint when its speed exceeds a threshold: final errors as a function of the
  // step. Adaptive methods get very loose tolerances, so that their steps are max_step; the exact solution has tight tolerances
  // and no step limit.
  const auto end = [](const std::string& method, double step, double tolerance) {
    Model model;
    model.add({.name = "rod",
               .mass = 1,
               .com = {0.4, 0, 0},
               .inertia = diagonal(0.01, 0.05, 0.05),
               .joint = Revolute{.axis = {0, 1, 0}}});
    Simulation sim(model, {.method = method,
                           .step = step,
                           .event_tolerance = 1e-13,
                           .rtol = tolerance,
                           .atol = tolerance,
                           .max_step = tolerance > 1 ? step : HUGE_VAL});
    sim.when(speed_of("rod").exceeds(4)).then(change_joint("rod", Ball{}));
    REQUIRE(sim.run_until(1) == Status::ok);
    REQUIRE(sim.events().size() == 1);
    return sim.world().motions()[0].pose.position + rotation_matrix(sim.world().motions()[0].pose.rotation) * Vec3{1, 0.2, 0};
  };
  const Vec3 exact = end("dop853", 1e-3, 1e-14);
  const struct {
    std::string name;
    double order, step;
  } methods[] = {{"rk4", 4, 5e-3}, {"dopri5", 5, 1e-2}};
  for (const auto& m : methods) {
    const double coarse = norm(end(m.name, m.step, 1e6) - exact), fine = norm(end(m.name, m.step / 2, 1e6) - exact);
    MESSAGE(m.name << " through a located event: error " << fine << ", order " << std::log2(coarse / fine));
    CHECK(std::log2(coarse / fine) > m.order - 0.3);
    CHECK(fine > 1e-12);  // of the method, not of rounding
  }
}

TEST_CASE("ten joints break at one instant, one after the other, the most overloaded first") {
  // Ten masses ride on a carriage that a spring slows down, each held by its own weld. The first weld fails when the spring's
  // force reaches its share; with every mass that breaks off the others carry more, and each was just below its strength.
  constexpr double stiffness = 40, speed = 3, own = 2, mass = 0.5;
  constexpr int count = 10;
  constexpr double all = own + count * mass;
  const double rate = std::sqrt(stiffness / all), reach = 0.8 * speed / rate;  // of the carriage at the break
  const int order[count] = {4, 7, 1, 9, 0, 3, 8, 6, 2, 5};                     // in which they fail
  const auto run_of = [&](bool backwards) {
    Model model({.gravity = {}});
    const BodyId carriage = model.add({.name = "carriage",
                                       .mass = own,
                                       .inertia = diagonal(0.1),
                                       .joint = Prismatic{.axis = x_axis, .stiffness = stiffness},
                                       .v = speed});
    double strength[count];
    for (int place = 0; place < count; ++place) strength[order[place]] = stiffness * reach / all * mass * (1 + 0.002 * place);
    for (int k = 0; k < count; ++k)
      model.add(
          {.name = "m/" + std::to_string(k), .mass = mass, .inertia = diagonal(0.01), .parent = carriage, .at = {0, 0.1 * k, 0}});
    Simulation sim(model, {.step = 2e-3});
    for (int i = 0; i < count; ++i) {
      const int k = backwards ? count - 1 - i : i;
      const std::string joint = "m/" + std::to_string(k);
      sim.when(reaction_force(joint).exceeds(strength[k])).then(break_joint(joint)).named("snap " + std::to_string(k));
    }
    REQUIRE(sim.run_until(0.7) == Status::ok);
    return sim;
  };
  const Simulation sim = run_of(false), other = run_of(true);
  REQUIRE(sim.events().size() == count);
  REQUIRE(other.events().size() == count);
  CHECK(std::fabs(sim.events()[0].time - std::asin(0.8) / rate) < 1e-9);
  for (int place = 0; place < count; ++place) {
    const Event& event = sim.events()[static_cast<std::size_t>(place)];
    CHECK(event.name == "snap " + std::to_string(order[place]));
    CHECK(event.time == sim.events()[0].time);
    CHECK(norm(event.after.linear - event.before.linear) < 1e-13);
    CHECK(norm(event.after.angular - event.before.angular) < 1e-13);
    CHECK(std::fabs(event.after.kinetic - event.before.kinetic) < 1e-13);
    // Independent of the order of scheduling, to the last bit.
    CHECK(other.events()[static_cast<std::size_t>(place)].name == event.name);
    CHECK(other.events()[static_cast<std::size_t>(place)].time == event.time);
  }
  CHECK(sim.world().mechanisms().size() == count + 1);
  for (std::size_t b = 0; b <= count; ++b) {
    CHECK(sim.world().motions()[b].pose.position.x == other.world().motions()[b].pose.position.x);
    CHECK(sim.world().motions()[b].linear.x == other.world().motions()[b].linear.x);
  }
}
