#pragma once
// What acts on a body from outside, beside gravity.
#include <array>
#include <functional>
#include <string>
#include <vector>

#include <momentree/math/signal.hpp>
#include <momentree/math/vec.hpp>
#include <momentree/tree/ids.hpp>

namespace momentree {

/// Resistance of still air or water: −(linear + quadratic·area·|v|)·v, where v is the velocity of the point in the world. With
/// the area left at 1, `quadratic` is in N s²/m²; with an area in m² it is ½·density·c_d, in kg/m³.
struct Drag {
  double linear = 0;     ///< N s/m
  double quadratic = 0;  ///< N s²/m², or kg/m³ with an area
  double area = 1;
  bool any() const { return linear != 0 || (quadratic != 0 && area != 0); }
  friend bool operator==(const Drag&, const Drag&) = default;
};

/// A force at a point of a body, a torque on the body, and drag at that point. It belongs to the body, whatever the body is
/// joined to, and leaves the world with it.
struct BodyForce {
  BodyId body;
  Vec3 point{};                    ///< where force and drag act, in the body's frame (m)
  std::array<Signal, 3> force{};   ///< N
  std::array<Signal, 3> torque{};  ///< N m
  bool body_axes = false;          ///< force and torque turn with the body; else they stand in world axes
  Drag drag{};
  friend bool operator==(const BodyForce&, const BodyForce&) = default;
};

struct Wrench {
  Vec3 force, torque;  ///< N, N m
};

class EvaluationContext;
/// What acts on a body, as a function of the world: about the origin of the body's frame, in world axes. Called at every stage of
/// a step; must not throw, and what it returns may depend on the moment alone.
using BodyFunction = std::function<Wrench(const EvaluationContext&)>;

/// What is wrong with a force by itself: empty if nothing. `field` names the scenario key at fault.
struct ForceProblem {
  std::string field, what, hint;
};
std::vector<ForceProblem> check_force(const BodyForce& force);

}  // namespace momentree
