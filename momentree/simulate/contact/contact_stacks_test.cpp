// The forces of contacts of stacks, whichever body was added first, and after contacts opened. (Of single bodies:
// contact_forces_test.cpp.)
#include <cmath>
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81;

struct Sums {
  Vec3 force{}, moment{};  // on a body, and about its centre of mass
  int points = 0;
};
Sums sums_on(const Simulation& sim, BodyId body) {
  const BodyMotion& motion = sim.world().motions()[static_cast<std::size_t>(body.index)];
  const Vec3 centre = motion.pose * sim.world().model()[body].com;
  Sums sums;
  for (const ContactPoint& contact : sim.world().contacts()) {
    if (contact.one != body && contact.other != body) continue;
    const Vec3 force = contact.one == body ? contact.force : -contact.force;
    sums.force += force, sums.moment += cross(contact.point - centre, force);
    ++sums.points;
  }
  return sums;
}

BodySpec crate(std::string name, const Vec3& at, const Quat& turned = {}) {
  return {.name = std::move(name),
          .mass = 3,
          .com = {0.04, -0.03, 0.01},
          .inertia = diagonal(0.05, 0.06, 0.07),
          .joint = Free{},
          .q = {at.x, at.y, at.z, turned.w, turned.x, turned.y, turned.z}};
}

void add_box(Model& model, BodyId body, const Vec3& size) { model.add_collider({.body = body, .solid = contact::box(size)}); }

}  // namespace

TEST_CASE("contact points: of a stack, each box is carried by the one below, whichever was added first") {
  for (const bool upper_first : {false, true}) {
    Model model;
    const BodyId one = model.add(crate(upper_first ? "upper" : "lower", {0, 0, upper_first ? 0.45 : 0.15}));
    const BodyId two = model.add(crate(upper_first ? "lower" : "upper", {0.02, 0.01, upper_first ? 0.15 : 0.45}));
    add_box(model, one, {0.4, 0.4, 0.3}), add_box(model, two, {0.3, 0.3, 0.3});
    model.add_collider({.plane = true});
    Simulation sim(model, {.method = "dop853"});
    REQUIRE(sim.run_until(0.05));
    const BodyId upper = upper_first ? one : two, lower = upper_first ? two : one;
    CHECK(norm(sums_on(sim, upper).force - Vec3{0, 0, 3 * g}) < 1e-9);
    CHECK(norm(sums_on(sim, upper).moment) < 1e-9);
    CHECK(norm(sums_on(sim, lower).force - Vec3{0, 0, 3 * g}) < 1e-9);
    CHECK(norm(sums_on(sim, lower).moment) < 1e-9);
  }
}

TEST_CASE("contact points: there are none without contact, nor after a contact opened") {
  Model model;
  const BodyId box = model.add(crate("box", {0, 0, 1.15}));
  add_box(model, box, {0.4, 0.3, 0.3});
  CHECK(Simulation(model, {}).world().contacts().empty());
  model.add_collider({.plane = true});
  Simulation sim(model, {.method = "dop853"});
  CHECK(sim.world().contacts().empty());
  REQUIRE(sim.run_until(0.6));
  CHECK_FALSE(sim.world().contacts().empty());
  CHECK(sim.world().contacts().size() == sim.branch().world().contacts().size());
  const Vec3 up{0, 0, 40};
  sim.force("box", [up](const EvaluationContext&) { return Wrench{up, cross(Vec3{0.04, -0.03, 0.01}, up)}; });
  REQUIRE(sim.run_until(0.7));
  CHECK(sim.world().contacts().empty());
}

// A light box below a heavy one carries a thousand times its weight, or a million times.
TEST_CASE("stepping: light boxes carry heavy ones, and nothing at rest moves") {
  for (const double ratio : {0.5, 1.0, 2.0, 10.0}) {
    CAPTURE(ratio);
    const int boxes = ratio == 10 ? 6 : 20;
    Model model;
    double weight = 0;
    for (int k = 0; k < boxes; ++k) {
      const double mass = std::pow(ratio, k);
      const BodyId box = model.add({.name = "box/" + std::to_string(k),
                                    .mass = mass,
                                    .inertia = diagonal(mass / 150),
                                    .joint = Free{},
                                    .q = {0.002 * (7 * k % 5), 0.003 * (3 * k % 5), 0.1 + 0.2 * k, 1, 0, 0, 0}});
      add_box(model, box, {0.2, 0.2, 0.2});
      weight += mass * g;
    }
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = 0.5, .static_friction = 0.5}});
    Simulation sim(model, {.method = "stepping", .step = 1e-3});
    REQUIRE(sim.run_until(0.5));
    CHECK(sim.warnings().empty());
    for (int k = 0; k < boxes; ++k) {
      const Vec3 at = sim.world().motions()[static_cast<std::size_t>(k)].pose.position;
      CHECK(norm(at - Vec3{0.002 * (7 * k % 5), 0.003 * (3 * k % 5), 0.1 + 0.2 * k}) < 2e-10);
    }
    double carried = 0;
    for (const ContactPoint& point : sim.world().contacts()) carried += point.other == ground ? point.force.z : 0;
    CHECK(std::fabs(carried - weight) < 1e-8 * weight);
  }
}

// A box that falls h bounces for √(2h/g) (1 + e)/(1 − e) on what does not give way; on a column that does, for less than twice as
// long.
TEST_CASE("stepping: a box that bounces on a column of others comes to rest") {
  for (const double e : {0.3, 0.5, 0.7, 0.9})
    for (const auto& [count, tilt] : {std::pair{2, 0.0}, {2, 1e-12}, {2, 1e-6}, {4, 0.0}}) {
      Model model;
      for (int k = 0; k < count; ++k) {
        const bool top = k + 1 == count;
        BodySpec box = crate("box" + std::to_string(k), {0, 0, 0.15 + 0.3 * k + (top ? 0.05 : 0)}, {1, top ? tilt : 0, 0, 0});
        box.com = {};
        add_box(model, model.add(std::move(box)), {0.3, 0.3, 0.3});
      }
      model.add_collider({.plane = true});
      model.add_contact_rule({.law = {.restitution = e}});
      model.add_contact_rule({.other = {ground}, .law = {}});
      Simulation sim(model, {.method = "stepping", .step = 1e-3});
      REQUIRE(sim.run_until(2 * std::sqrt(2 * 0.05 / g) * (1 + e) / (1 - e) + 0.2));
      for (const BodyMotion& motion : sim.world().motions()) CHECK(norm(motion.linear) < 1e-3);
    }
}
