// Bodies that are added and removed while a world runs.
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

Model chain(int links) {
  Model model;
  BodyId last = ground;
  for (int k = 1; k <= links; ++k)
    last = model.add({.name = "c/" + std::to_string(k),
                      .mass = 0.5,
                      .com = {0.1, 0, 0},
                      .inertia = diagonal(0.002),
                      .parent = last,
                      .at = {k == 1 ? 0.0 : 0.2, 0, 0},
                      .joint = Revolute{.axis = {0, 1, 0}, .damping = 0.01},
                      .q = 0.2,
                      .v = 0.5});
  return model;
}

BodySpec load(BodyId parent) {
  return {.name = "load", .mass = 2, .inertia = diagonal(0.01), .parent = parent, .at = {0.2, 0, 0}, .joint = Ball{}};
}

}  // namespace

TEST_CASE("adding a body at rest changes no other velocity, and the body moves along from then on") {
  Simulation sim(chain(4));
  CHECK(sim.run_until(0.1) == Status::ok);
  const auto before = sim.world().motions();
  const double energy = sim.energy().error;
  const BodyId body = sim.add(load({3}));
  CHECK(body.index == 4);
  for (std::size_t b = 0; b < 4; ++b) CHECK(norm(sim.world().motions()[b].linear - before[b].linear) < 1e-12);
  CHECK(sim.energy().error == doctest::Approx(energy).epsilon(1e-9));
  CHECK(sim.events().back().after.kinetic > sim.events().back().before.kinetic);  // it was added with the energy of its motion
  CHECK(sim.events().back().actions[0].text() == "add load");
  CHECK(sim.run_until(0.3) == Status::ok);
  CHECK(std::fabs(sim.energy().error) < 1e-6);
  sim.apply(break_joint("load"));
  CHECK(sim.world().mechanism_names() == std::vector<std::string>{"c", "load"});
}

TEST_CASE("removing a body changes nothing else, and the use of its handle is detected") {
  Simulation sim(chain(6)), free(chain(6));
  CHECK(sim.run_until(0.1) == Status::ok);
  CHECK(free.run_until(0.1) == Status::ok);
  free.apply(break_joint("c/4"));
  sim.remove({3});
  CHECK_FALSE(sim.world().alive({3}));
  CHECK_FALSE(sim.world().alive({5}));
  CHECK(sim.world().alive({2}));
  CHECK(sim.world().mechanisms().size() == 1);
  CHECK(sim.world().tree().nv() == 3);
  CHECK(sim.run_until(0.5) == Status::ok);
  CHECK(free.run_until(0.5) == Status::ok);
  for (std::size_t b = 0; b < 3; ++b) CHECK(norm(sim.world().motions()[b].linear - free.world().motions()[b].linear) < 1e-12);
  CHECK_THROWS_AS(sim.remove({3}), Error);
  CHECK(sim.apply(lock("c/5")).actions[0].text().find("skipped") != std::string::npos);
  CHECK_THROWS_AS(sim.apply(weld("c/5", "c/1")), Error);
  CHECK_THROWS_AS(sim.add(load({3})), Error);
  CHECK(std::fabs(sim.energy().error) < 1e-6);
}

TEST_CASE("snapshots and branches contain the bodies that existed") {
  Simulation sim(chain(3));
  CHECK(sim.run_until(0.1) == Status::ok);
  const SimulationSnapshot early = sim.snapshot();
  sim.add(load({2}));
  CHECK(sim.run_until(0.2) == Status::ok);
  sim.remove({1});
  const SimulationSnapshot late = sim.snapshot();
  Simulation branch = sim.branch();
  CHECK(branch.world().alive({0}));
  CHECK_FALSE(branch.world().alive({1}));
  CHECK_FALSE(branch.world().alive({3}));  // the removed body carried it
  sim.restore(early);
  CHECK(sim.world().model().size() == 3);
  CHECK(sim.world().alive({1}));
  CHECK(sim.run_until(0.2) == Status::ok);
  sim.restore(late);
  CHECK(sim.world().model().size() == 4);
  CHECK_FALSE(sim.world().alive({3}));
  CHECK(sim.run_until(0.4) == Status::ok);
  CHECK(branch.run_until(0.4) == Status::ok);
  CHECK(sim.world().motions()[0].linear == branch.world().motions()[0].linear);
}

TEST_CASE("a body without inertia where it needs one is not added") {
  Simulation sim(chain(2));
  CHECK_THROWS_AS(sim.add({.name = "point", .mass = 1, .parent = {1}, .joint = Revolute{}}), Error);
  CHECK_THROWS_AS(sim.add({.name = "c/1", .mass = 1, .inertia = diagonal(1), .parent = {1}}), Error);
  CHECK(sim.world().model().size() == 2);
  CHECK(sim.world().tree().bodies() == 2);
  CHECK(sim.run_until(0.1) == Status::ok);
}
