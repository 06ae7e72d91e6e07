// Contacts of bodies that are welded or driven, and bounces on what other contacts press against.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

void add_floor(Model& model, double friction, double restitution) {
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction, .restitution = restitution}});
}

}  // namespace

TEST_CASE("contact: friction against a prescribed motion does work, although it changes no velocity") {
  for (const char* method : {"rk4", "dop853", "stepping"}) {
    Model model;
    const BodyId cart = model.add({.name = "cart",
                                   .mass = 1,
                                   .inertia = diagonal(0.01),
                                   .at = {{0, 0, 1}},
                                   .joint = Prismatic{.axis = {1, 0, 0}, .drive = motion_drive(Signal::sine(0.5, 1))}});
    const BodyId pin = model.add({.name = "pin",
                                  .mass = 2,
                                  .inertia = diagonal(0.01),
                                  .parent = cart,
                                  .at = {{0, 0, -0.9}},
                                  .joint = Prismatic{.axis = {0, 0, 1}}});
    model.add_collider({.body = pin, .solid = contact::sphere(0.1)});
    add_floor(model, 0.5, 0);
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(0.1));
    const std::vector<ContactPoint> contacts = sim.world().contacts();
    CAPTURE(method);
    REQUIRE(contacts.size() == 1);
    CHECK(norm(contacts[0].force - Vec3{-9.81, 0, 2 * 9.81}) < 1e-6);
    CHECK(contacts[0].slips);
    const double travelled = sim.world().motions()[1].pose.position.x,
                 lost = sim.energy().dissipated + sim.energy().lost_in_impacts;
    CHECK(lost == doctest::Approx(9.81 * travelled).epsilon(2e-3));
    CHECK(std::fabs(sim.energy().error) < 1e-6);
  }
}

TEST_CASE("contact: fingers that touch and then grasp, by a lock or a weld, are one rigid body, also with massless pads") {
  for (const double rate : {1.0, 5.0})
    for (const bool pads : {false, true})
      for (const bool weld_them : {false, true})
        for (const char* method : {"rk4", "dop853", "stepping"}) {
          Model model({.gravity = {}});
          const BodyId hub = model.add({.name = "hub",
                                        .mass = 1,
                                        .inertia = diagonal(0.01, 0.012, 0.017),
                                        .joint = Free{},
                                        .v = {0, 0, 0, 0.3, 0.5, 0.2}});
          const auto finger = [&](const std::string& name, double side, double turns) {
            const BodyId body = model.add({.name = name,
                                           .mass = 0.5,
                                           .com = {0, 0, 0.2},
                                           .inertia = diagonal(0.004),
                                           .parent = hub,
                                           .at = {{0.2 * side, 0, 0.1}},
                                           .joint = Revolute{.axis = {0, 1, 0}},
                                           .v = {turns}});
            const Vec3 tip{0, 0.01 * side, 0.32};
            if (pads)
              model.add_collider(
                  {.body = model.add({.name = name + "_pad", .parent = body, .at = {tip}}), .solid = contact::sphere(0.1)});
            else
              model.add_collider({.body = body, .solid = contact::sphere(0.1, {tip})});
          };
          finger("left", -1, rate), finger("right", 1, -0.8 * rate);
          Simulation sim(model, {.method = method, .step = 1e-3});
          Simulation::Scheduled grasp = sim.when(pads ? touching("left_pad", "right_pad") : touching("left", "right"));
          if (weld_them)
            grasp.then(weld("left", "right"));
          else
            grasp.then(lock("left")).then(lock("right"));
          const Totals start = sim.world().totals();
          const RunResult run = sim.run_until(3);
          CAPTURE(method);
          INFO(run.reason);
          REQUIRE(run);
          const Totals end = sim.world().totals();
          CHECK(!sim.events().empty());
          const bool slow = rate == 1, steps = std::string(method) == "stepping";
          CHECK(norm(end.linear - start.linear) < (slow ? 1e-9 : 1e-8));
          CHECK(norm(end.angular - start.angular) < (steps ? slow ? 1e-4 : 1e-2 : slow ? 1e-9 : 1e-8));
          CHECK(end.kinetic == doctest::Approx(start.kinetic - sim.energy().lost_in_impacts).epsilon(slow ? 1e-9 : 1e-7));
          CHECK((!slow || end.kinetic > 0.5 * start.kinetic));
          for (const ContactPoint& contact : sim.world().contacts()) CHECK(norm(contact.force) < 1e-9);
        }
}

TEST_CASE("contact: bodies with hardly any inertia, or none, are stopped by floors and cables like all others") {
  for (const double inertia : {0.0, 1e-22, 1e-18, 1e-16, 1e-12})
    for (const bool cable : {false, true})
      for (const char* method : {"rk4", "dop853", "stepping"}) {
        Model model;
        const BodyId body = model.add({.name = "b",
                                       .mass = 0.6,
                                       .com = {inertia == 1e-16 && !cable ? 0 : 0.1, 0, 0},
                                       .inertia = diagonal(inertia),
                                       .joint = Cylindrical{.axis = {0, 0, 1}}});
        if (cable) {
          model.add_spring({.name = "rope",
                            .from = {ground, {0.1, 0, 1}},
                            .to = {body, {0.15, 0.02, 0}},
                            .rest = std::sqrt(1.25 * 1.25 + 0.05 * 0.05 + 0.02 * 0.02),
                            .inextensible = true});
        } else {
          model.add_collider({.body = body, .solid = contact::sphere(0.05, {{0.15, 0.02, 0}})});
          model.add_collider({.plane = true, .point = {0, 0, -0.3}});
        }
        Simulation sim(model, {.method = method, .step = 1e-3});
        CAPTURE(inertia);
        CAPTURE(cable);
        CAPTURE(std::string(method));
        REQUIRE(sim.run_until(0.5));
        const double height = sim.world().motions()[0].pose.position.z;
        if (!cable) CHECK(height == doctest::Approx(-0.25).epsilon(method == std::string("stepping") ? 1e-3 : 1e-9));
        // On the cable it may turn about its axis until its end is nearest to the line below the anchor.
        if (cable) CHECK(height > -0.2502 - (method == std::string("stepping") ? 1e-3 : 0));
      }
}

TEST_CASE("contact: a chain comes to rest on a floor, or the run ends with the links that lack an inertia") {
  for (const double inertia : {1e-6, 0.0}) {
    Model model;
    BodyId last{};
    for (int i = 1; i <= 4; ++i) {
      BodySpec link{.name = "c/" + std::to_string(i), .mass = 0.1, .com = {0.1, 0, 0}, .inertia = diagonal(inertia)};
      if (i == 1)
        link.joint = Free{}, link.q = {0, 0, 0.5, 1, 0, 0, 0};
      else
        link.parent = last, link.at = {0.2, 0, 0}, link.joint = Revolute{.axis = {0, 1, 0}}, link.q = 0.1;
      last = model.add(link);
      model.add_collider(
          {.body = last, .solid = contact::capsule(0.02, 0.2, {{0.1, 0, 0}, from_rpy(0, std::numbers::pi / 2, 0)})});
    }
    add_floor(model, 0.5, 0);
    Simulation sim(model, {.method = "dop853"});
    const RunResult run = sim.run_until(1);
    CAPTURE(inertia);
    INFO(run.reason);
    if (inertia == 0 && !run) {
      CHECK(run.reason.find("an inertia for bodies that have none, such as 'c/1'") != std::string::npos);
      continue;
    }
    REQUIRE(run);
    CHECK(sim.world().totals().kinetic < 1e-9);
    CHECK(sim.world().totals().potential == doctest::Approx(4 * 0.1 * 9.81 * 0.02).epsilon(1e-6));
  }
}

TEST_CASE("contact: a ball that friction on the floor presses against a wall comes to rest on the wall") {
  for (const char* method : {"rk4", "dop853"}) {
    Model model;
    const BodyId ball = model.add({.name = "ball",
                                   .mass = 1,
                                   .inertia = diagonal(0.4 * 0.01),
                                   .joint = Free{},
                                   .q = {-0.02, 0, 0.1, 1, 0, 0, 0},
                                   .v = {0, 0.5, 0, 0, 100, 0}});  // it spins so that the floor pushes it towards the wall
    model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
    const BodyId wall = model.add({.name = "wall", .mass = 1, .inertia = diagonal(1), .at = {{0.5, 0, 0}}});
    model.add_collider({.body = wall, .solid = contact::box({0.8, 6, 1})});
    add_floor(model, 0.4, 0.2);
    Simulation sim(model, {.method = method, .step = 1e-3});
    const RunResult run = sim.run_until(0.4);
    CAPTURE(method);
    INFO(run.reason);
    REQUIRE(run);
    CHECK(sim.events().size() < 200);
    CHECK(std::none_of(sim.events().begin(), sim.events().end(), [](const Event& e) { return e.name == "stepping"; }));
    CHECK(std::any_of(sim.events().begin(), sim.events().end(), [](const Event& e) {
      return (e.name == "rest" || e.name == "slip") && (e.contact.other == "wall" || e.contact.one == "wall");
    }));
  }
}
