#pragma once
// What programs that check new shapes have in common.
#include <cmath>
#include <cstdio>
#include <string>

#include <momentree/contact/primitive.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {

inline constexpr double g = 9.81, density = 800;

/// Returns the number of failures so far.
inline int check(bool holds, const std::string& what) {
  static int failures = 0;
  if (!holds) std::printf("wrong: %s\n", what.c_str()), ++failures;
  return failures;
}
inline bool near(double a, double b, double tolerance) { return std::fabs(a - b) <= tolerance; }

/// A free body of uniform density.
inline BodySpec body_of(const contact::Primitive& shape, const char* name, const Pose& at) {
  const contact::UniformBody uniform = contact::uniform(shape);
  const Vec3 I = density * uniform.moments;
  const Quat& r = at.rotation;
  return {.name = name,
          .mass = density * uniform.volume,
          .inertia = diagonal(I.x, I.y, I.z),
          .joint = Free{},
          .q = {at.position.x, at.position.y, at.position.z, r.w, r.x, r.y, r.z}};
}

/// A body above a floor.
inline Model on_floor(const contact::Primitive& shape, const Pose& at, double friction, const Values& v = {}) {
  Model model({.gravity = {0, 0, -g}});
  BodySpec spec = body_of(shape, "body/body", at);
  spec.v = v;
  const BodyId body = model.add(spec);
  model.add_collider({.body = body, .solid = contact::solid(shape, {})});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction}});
  return model;
}

/// One shape falls on another, which is fixed: their distance, and the height at which it comes to rest, located and stepped
/// through. `base_top`, `body_bottom`: extents above and below the centres of mass.
inline void check_pair(const contact::Primitive& base, double base_top, const contact::Primitive& body, double body_bottom) {
  const std::string pair = std::string(" of a ") + contact::info(body).key + " on a " + contact::info(base).key;
  constexpr double gap = 0.1;
  Model model({.gravity = {0, 0, -g}});
  const BodyId below = model.add({.name = "base/base", .mass = 1, .inertia = diagonal(1), .joint = Weld{}});
  const BodyId above = model.add(body_of(body, "body/body", {{0, 0, base_top + gap + body_bottom}, {}}));
  model.add_collider({.body = below, .solid = contact::solid(base, {})});
  model.add_collider({.body = above, .solid = contact::solid(body, {})});
  check(near(World(model).gap(below, above)->distance, gap, 1e-12), "distance" + pair);
  for (const char* method : {"dop853", "stepping"}) {
    Simulation sim(model, {.method = method, .step = 1e-3});
    check(bool(sim.run_until(0.3)), "a fall" + pair);
    check(near(sim.world().motions()[1].pose.position.z, base_top + body_bottom, 1e-8), "height" + pair + ", " + method);
  }
}

}  // namespace momentree
