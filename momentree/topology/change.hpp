#pragma once
// Topology changes: bookkeeping in canonical momenta. Each applies at any instant to (tree, state), reads a workspace evaluated
// on this very state, allocates nothing and solves no system for an impulse. The universal rule: p of the changed joint is E′ᵀ
// Pb, its ancestors shed or absorb Pb along the path to the root, and everything else is unchanged; the next evaluation finds the
// velocities.
//
// `apply` requires a workspace evaluated on this state and this tree (call forward_dynamics first); afterwards the workspace is
// stale. A change that cannot be applied is a programming error and stops the program before anything has changed: a body that
// does not exist, a number that is not finite, a joint with faults by check_joint(), and the conditions of each change. Code that
// takes changes from users checks first: `can_break`, `floats`, `root_of`, `Tree::alive`, `check_joint`, `check_body`.
#include <momentree/dynamics/workspace.hpp>
#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Complete failure of a joint, see can_break() (paper, section 4.1): the body that carries it and all outboard ones
/// become a separate mechanism. The ancestors shed its momentum (29); the new root's momentum is its articulated momentum; no
/// velocity changes.
struct Break {
  JointId joint;
};

/// Replaces a joint, without changing the pose, by `to`, with unit axes, at coordinates q. to.parameters selects the parameters.
/// If the new DoFs contain the old ones, no velocity changes; otherwise this is a plastic impact, p′ = E′ᵀ Pb (28). Locks of the
/// old joint do not carry over. `direction`: the declared child of the new joint; the body that carries it (declared), that
/// body's parent (reversed: not the ground; then the joint's `at` is in the body's frame and `child_at` in the parent's), or as
/// for the present joint (keep).
struct ChangeJoint {
  enum class Direction : unsigned char { keep, declared, reversed };
  JointId joint;
  Joint to;
  Values q;
  Direction direction = Direction::keep;
};

/// Freezes DoFs of a joint in place (a bit per DoF, in the order of v), by the plastic impact that this
/// causes: their momenta are dropped.
struct Lock {
  JointId joint;
  unsigned dofs = ~0u;
};
/// Releases locked DoFs, initially at rest: p = Eᵀ Pb. No velocity changes, except for a joint with prescribed motion, which
/// takes the position and rate of the motion from now on, see SetParameters.
struct Unlock {
  JointId joint;
  unsigned dofs = ~0u;
};

/// Makes `body` the root of its floating mechanism. Nothing physical changes: no pose, velocity or acceleration of any body.
struct Reroot {
  BodyId body;
};

/// Joins the floating mechanism of `body` to `to` by a free joint at body's frame, in the present pose: no impulse; the ancestors
/// of `to` absorb its momentum. ChangeJoint then turns that joint into the intended one, such as a weld or a revolute joint
/// (several at one instant are one impact). `to` == ground: body becomes a root on its own free joint, ready to be joined to the
/// ground.
struct Join {
  BodyId body, to;
};

/// Join and ChangeJoint at once, from one evaluation: attaches the floating mechanism of `body` to `to` by `joint`, at
/// coordinates q that together with the joint's placements give the present pose. `reversed`: the joint's declared child is `to`.
/// joint.parameters selects the parameters. p = E′ᵀ Pb, a plastic impact in the directions that the joint blocks.
struct Attach {
  BodyId body, to;
  Joint joint;
  Values q;
  bool reversed = false;
};

/// An impulsive wrench on a body: world axes, force in N s at `point` (user frame of the body, m), torque in N m s.
struct Impulse {
  BodyId body;
  Vec3 force{}, torque{}, point{};
};

/// Impact on one DoF (in the order of v) of a joint, as against a stop: u⁺ = −restitution u⁻, by an impulse
/// along that DoF alone. The kinetic energy lost is 1 − restitution² times that of a plastic impact. Costs one evaluation.
struct Impact {
  JointId joint;
  int dof = 0;
  double restitution = 0;  ///< 0 (plastic) to 1
};

/// Sets new parameters of a joint; velocities are kept, so an armature changes p. If they prescribe a
/// motion, the joint takes its position and rate from now on, with the impulse that this needs (all other momenta are kept). If
/// they end a prescribed motion, the joint keeps its velocity, and p = Eᵀ Pb + armature·v.
struct SetParameters {
  JointId joint;
  JointParameters parameters;
};

/// Adds a loop joint between two bodies, or a body and the ground, whose frames are closed in the present pose: a plastic impact
/// in the directions that it blocks. `turns`: its present angles. A state in momenta continues in velocities. May
/// allocate.
struct MakeLoop {
  Loop loop;
  Turns turns{};
};
/// Removes a loop joint: no velocity changes. `keeps_energy`: its spring takes part in a joint that replaces it.
struct BreakLoop {
  JointId joint;
  bool keeps_energy = false;
};
/// Replaces a loop joint, without changing the pose: kind, frames, locks (with the coordinates at which DoFs are `held`) and
/// parameters. `impact`: the new joint blocks more directions; otherwise no velocity changes. `turns`: its present angles.
struct SetLoop {
  JointId joint;
  Joint to;
  JointParameters parameters;
  Values held{};
  Turns turns{};
  bool impact = false;
  bool keeps_energy = true;  ///< the energy of its spring stays with the joint
};

/// Ends a coupling of joints, which must act: no velocity changes.
struct EndCoupling {
  CouplingId coupling;
};

/// Removes a spring between two points, which must not be broken. No velocity changes; the energy that it stored is released.
struct BreakSpring {
  SpringId spring;
};

/// Sets the law of a spring between two points, which must not be broken. No velocity changes.
struct SetSpring {
  SpringId spring;
  SpringLaw law;
};

/// Removes `body` and all outboard ones from the world: a whole floating mechanism with `body` as its root (break it off first if
/// it is attached). The others are not affected. Body numbers are not used again: `Tree::alive` is then false, and any other use
/// stops the program.
struct Remove {
  BodyId body;
};

/// Adds a body on any existing one or on the ground, with the coordinates and velocities of its spec, which is complete as
/// Model::operator[] returns it. No velocity of another body changes. Storage grows, which may allocate: workspaces and
/// integrators must be made anew. Numbers are not reused, so a world that adds and removes bodies indefinitely grows by about 800
/// bytes per body.
struct Add {
  const BodySpec* spec;
};

/// Energy that a change released from springs and armatures, beyond the energy of the bodies (J).
struct Released {
  double energy = 0;
};

Released apply(const Break& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const ChangeJoint& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const Lock& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const Unlock& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const Reroot& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const Join& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const Attach& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const Impulse& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const SetParameters& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
JointId apply(const MakeLoop& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const BreakLoop& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const SetLoop& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const EndCoupling& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const BreakSpring& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const SetSpring& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
/// Returns the impulse on the DoF (N s, or N m s). The topology does not change.
double apply(const Impact& change, const Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const Remove& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
/// Returns the new body.
BodyId apply(const Add& change, Tree& tree, State& state, const Workspace<double>& workspace);

/// Root of the mechanism that a body belongs to.
[[nodiscard]] BodyId root_of(const Tree& tree, BodyId body) noexcept;
/// True for a mechanism whose root has a free joint to the ground without spring, damper, friction, drive or armature: it can be
/// re-rooted.
[[nodiscard]] bool floats(const Tree& tree, BodyId body) noexcept;
/// True if the joint can break: any but a free joint to the ground without locks and parameters.
[[nodiscard]] bool can_break(const Tree& tree, JointId joint) noexcept;

}  // namespace momentree
