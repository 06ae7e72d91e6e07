#pragma once
// Boxes that lie on a floor and on each other, shared by tests of contact.
#include <cstddef>
#include <string>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::testing {

inline constexpr double g = 9.81, friction = 0.4, box_mass = 2;  // m/s², kg

/// A box of 0.4 × 0.4 × 0.2 m, whose centre is at that height above its parent.
inline BodyId add_box(Model& model, const std::string& name, double height, BodyId parent = ground, JointSpec joint = Free{}) {
  BodySpec box{.name = name, .mass = box_mass, .inertia = diagonal(0.02), .parent = parent, .joint = joint};
  if (parent == ground)
    box.q = {0, 0, height, 1, 0, 0, 0};
  else
    box.at = {0, 0, height};
  const BodyId body = model.add(box);
  model.add_collider({.body = body, .solid = contact::box({0.4, 0.4, 0.2})});
  return body;
}

/// A stack of them, `above` the floor (m).
inline Model boxes(int count, double above = 0) {
  Model model({.gravity = {0, 0, -g}});
  for (int k = 0; k < count; ++k) add_box(model, "box/" + std::to_string(k), 0.1 + 0.2 * k + above);
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction}});
  return model;
}

/// The sum of the forces of contacts on a body (N).
inline Vec3 force_on(const World& world, BodyId body) {
  Vec3 sum{};
  for (const ContactPoint& point : world.contacts()) {
    if (point.one == body) sum += point.force;
    if (point.other == body) sum += -point.force;
  }
  return sum;
}

}  // namespace momentree::testing
