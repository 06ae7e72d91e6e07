// Joints reported as too stiff are unstable; below the reported step they are not.
#include <doctest/doctest.h>

#include <cmath>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/stiffness.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {
namespace {

// An arm of three bodies with joint parameters `p` at its light end.
Model arm(const JointParameters& p, Kind kind = Kind::revolute) {
  Model model({.gravity = {}});
  const BodyId base = model.add({.name = "base", .mass = 5, .inertia = diagonal(0.4), .joint = Revolute{.axis = y_axis}});
  const BodyId link = model.add({.name = "link",
                                 .mass = 2,
                                 .com = {0.2, 0, 0},
                                 .inertia = diagonal(0.05),
                                 .parent = base,
                                 .at = {0.3, 0, 0},
                                 .joint = Revolute{.axis = y_axis}});
  BodySpec hand{.name = "hand", .mass = 0.1, .com = {0.05, 0, 0}, .inertia = diagonal(2e-4), .parent = link, .at = {0.4, 0, 0}};
  hand.joint.kind = kind;
  hand.joint.axis = y_axis;
  hand.joint.parameters = p;
  if (kind != Kind::weld) hand.v = 0.01;
  model.add(hand);
  return model;
}

std::optional<StiffJoint> judged(const Model& model, std::string_view method, double step) {
  const Tree tree(model);
  return too_stiff(tree, start_state(model, tree).q(), method, step);
}

// The largest speed of the hand within 400 steps.
double largest_speed(const Model& model, const char* method, double step) {
  Simulation simulation(model, {.method = method, .step = step});
  double largest = 0;
  simulation.observe(0, [&](const World& world) {
    largest = std::max(largest, std::fabs(world.joint({2}).v[0]));
    return true;
  });
  if (simulation.run_until(400 * step) != Status::ok) return HUGE_VAL;
  return largest;
}

JointParameters servo(double kp, double kd) {
  JointParameters p;
  p.drive = pd_drive({.kp = kp, .kd = kd});
  return p;
}

}  // namespace

TEST_CASE("a damper that is too strong for the step makes it unstable, and the suggested step is stable") {
  for (const bool by_servo : {false, true}) {
    JointParameters p;
    if (by_servo)
      p = servo(0, 8);
    else
      p.damping = 8;
    const Model model = arm(p);
    const auto stiff = judged(model, "rk4", 1e-3);
    REQUIRE(stiff);
    CHECK(stiff->damper);
    CHECK(stiff->servo == by_servo);
    CHECK(stiff->joint == 2);
    CHECK(stiff->coefficient == 8);
    CHECK(stiff->damped_helps);
    CHECK(stiff->longest_step < 1e-3);
    CHECK(largest_speed(model, "rk4", 1.02 * stiff->longest_step) > 1);
    CHECK(largest_speed(model, "rk4", 0.98 * stiff->longest_step) < 0.011);
    CHECK(largest_speed(model, "damped", 1e-3) < 0.011);
    CHECK_FALSE(judged(model, "rk4", 0.99 * stiff->longest_step));
    CHECK_FALSE(judged(model, "damped", 1e-3));
    CHECK_FALSE(judged(model, "dopri5", 1e-3));
  }
}

TEST_CASE("a spring that is too stiff for the step makes it unstable") {
  JointParameters p;
  p.stiffness = 4000;
  const Model model = arm(p);
  for (const char* method : {"rk4", "damped", "midpoint"}) {
    CAPTURE(method);
    const auto stiff = judged(model, method, 1e-2);
    REQUIRE(stiff);
    CHECK_FALSE(stiff->damper);
    CHECK_FALSE(stiff->damped_helps);  // springs are still explicit
    CHECK(stiff->coefficient == 4000);
    CHECK(largest_speed(model, method, 1.05 * stiff->longest_step) > 1);
    CHECK(largest_speed(model, method, 0.5 * stiff->longest_step) < 0.02);
  }
  CHECK(judged(model, "rk4", 1e-2)
            ->what("arm/hand", 1e-2)
            .starts_with("the spring of joint 'arm/hand' (stiffness = 4e+03 N m/rad on"));
}

TEST_CASE("dampers and springs of joints in loops are judged with the loops closed") {
  // Two bars from the ground, pinned at their tips: together they can only turn as one, about a common axis.
  const auto two_bars = [](const JointParameters& in_tree, const JointParameters& in_loop) {
    Model model({.gravity = {}});
    for (const char* name : {"light", "heavy"}) {
      BodySpec bar{.name = name, .mass = name[0] == 'l' ? 0.1 : 2, .com = {0.3, 0, 0}, .inertia = diagonal(0.01)};
      bar.joint.kind = Kind::revolute, bar.joint.axis = y_axis;
      if (name[0] == 'l') bar.joint.parameters = in_tree;
      bar.v = 0.01;
      model.add(bar);
    }
    BodySpec slider{.name = "slider", .mass = 0.5, .inertia = diagonal(0.01), .parent = BodyId{1}, .at = {0.4, 0, 0}};
    slider.joint.kind = Kind::prismatic, slider.joint.axis = {1, 0, 0};
    slider.q = 0.02;
    model.add(slider);
    LoopSpec pin;
    pin.name = "slot", pin.body = BodyId{2}, pin.to = BodyId{0};
    pin.joint.kind = Kind::prismatic, pin.joint.axis = {1, 0, 0};
    pin.joint.parameters = in_loop;
    pin.at.position = {0.42, 0, 0};
    model.add_loop(pin);
    return model;
  };
  JointParameters damper, spring;
  damper.damping = 800;
  spring.stiffness = 2e6;
  for (const bool in_loop : {false, true})
    for (const JointParameters& p : {damper, spring}) {
      CAPTURE(in_loop);
      CAPTURE(p.damping.of(0));
      const Model model = two_bars(in_loop ? JointParameters{} : p, in_loop ? p : JointParameters{});
      const auto speed = [&](const char* method, double step) {
        Simulation sim(model, {.method = method, .variables = Variables::momenta, .step = step});
        if (in_loop) sim.apply(impulse("slider", {0.005, 0, 0}));
        double largest = 0;
        sim.observe(0, [&](const World& world) {
          for (const double v : world.v()) largest = std::max(largest, std::fabs(v));
          return true;
        });
        return sim.run_until(400 * step) == Status::ok ? largest : HUGE_VAL;
      };
      const auto stiff = judged(model, "rk4", 1e-2);
      REQUIRE(stiff);
      CHECK(stiff->damper == (p.damping.of(0) > 0));
      CHECK(stiff->joint == (in_loop ? first_loop : 0));
      CHECK(speed("rk4", 1.05 * stiff->longest_step) > 1);
      CHECK(speed("rk4", 0.95 * stiff->longest_step) < 0.03);
      const auto implicit = judged(model, "damped", 1e-2);
      CHECK(implicit.has_value() == (in_loop || !stiff->damper));
      if (implicit) {
        CHECK(speed("damped", 1.05 * implicit->longest_step) > 1);
        CHECK(speed("damped", 0.95 * implicit->longest_step) < 0.03);
      } else {
        CHECK(speed("damped", 1e-2) < 0.03);
      }
    }
}

TEST_CASE("with the method damped, a servo's spring next to a strong damper needs no small steps") {
  const Model model = arm(servo(4000, 80));
  const auto stiff = judged(model, "rk4", 2e-3);
  REQUIRE(stiff);
  CHECK(stiff->damper);
  CHECK(stiff->damped_helps);
  CHECK(stiff->cure().starts_with("use method = \"damped\", or a step below "));
  CHECK(largest_speed(model, "damped", 2e-3) < 0.011);
}

TEST_CASE("joints that cannot move independently are not reported as too stiff") {
  CHECK_FALSE(judged(arm({}), "rk4", 1));
  JointParameters moved;
  moved.drive = motion_drive(Signal::sine(0.1, 1));
  moved.damping = 1e6;
  Model driven = arm(moved);
  CHECK_FALSE(judged(driven, "rk4", 1e-3));
}

TEST_CASE("a run that diverges on a servo names the method for it") {
  Simulation simulation(arm(servo(100, 8)), {.method = "rk4", .step = 1e-3});
  CHECK(simulation.run_until(5) == Status::diverged);
  CHECK(simulation.result().reason.find("the servo of joint 'hand' (kd = 8 N m s/rad on 0.000") != std::string::npos);
  CHECK(simulation.result().reason.find("is too stiff for steps of 0.001 s; use method = \"damped\", or a step below ") !=
        std::string::npos);
  Model fast({.gravity = {}});
  fast.add(
      {.name = "a", .mass = 1, .com = {0.3, 0, 0}, .inertia = diagonal(0.1), .joint = Free{}, .v = {0, 0, 0, 1e5, 2e5, 3e5}});
  Simulation wild(fast, {.method = "rk4", .step = 1});
  CHECK(wild.run_until(5) == Status::diverged);
  CHECK(wild.result().reason.find("a smaller step") != std::string::npos);
  CHECK(wild.result().reason.find("damped") == std::string::npos);
}

}  // namespace momentree
