#pragma once
// External forces on a body other than gravity.
#include <array>
#include <functional>
#include <string>
#include <vector>

#include <momentree/math/signal.hpp>
#include <momentree/math/vec.hpp>
#include <momentree/model/ids.hpp>

namespace momentree {

/// Drag in still air or water: −(linear + quadratic·area·|v|)·v, with v the velocity of the point in the world. If the area is
/// left at 1, `quadratic` is in N s²/m²; with an area in m² it is ½·density·c_d, in kg/m³.
struct Drag {
  double linear = 0;     ///< N s/m
  double quadratic = 0;  ///< N s²/m², or kg/m³ if an area is given
  double area = 1;
  bool any() const { return linear != 0 || (quadratic != 0 && area != 0); }
  friend bool operator==(const Drag&, const Drag&) = default;
};

/// A force at a point of a body, a torque on the body, and drag at that point. It belongs to the body, whatever the body is
/// attached to, and leaves the world with it.
struct BodyForce {
  BodyId body;
  Vec3 point{};                    ///< where force and drag act, in the body's user frame (m)
  std::array<Signal, 3> force{};   ///< N
  std::array<Signal, 3> torque{};  ///< N m
  bool body_axes = false;          ///< true: force and torque are in body axes and rotate with the body; false: in world axes
  Drag drag{};
  friend bool operator==(const BodyForce&, const BodyForce&) = default;
};

struct Wrench {
  Vec3 force, torque;  ///< N, N m
};
/// Components of a reaction in the child's axes, as bits: force x, y, z, then torque x, y, z about the joint's frame.
using ReactionParts = unsigned;
inline constexpr ReactionParts force_parts = 0b111, torque_parts = 0b111000, all_parts = force_parts | torque_parts;

class EvaluationContext;
/// A wrench on a body as a function of the world: about the origin of the body's user frame, in world axes. Called at every stage
/// of a step; must not throw, and its result may depend only on the evaluation context.
using BodyFunction = std::function<Wrench(const EvaluationContext&)>;

/// The faults of a single force; empty if there are none. `field` is the key of the scenario file at fault.
struct ForceProblem {
  std::string field, what, hint;
};
std::vector<ForceProblem> check_force(const BodyForce& force);

}  // namespace momentree
