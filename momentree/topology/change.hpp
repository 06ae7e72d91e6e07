#pragma once
// Topology changes: bookkeeping in canonical momenta. Each applies at any instant to (tree, state), reads a work that was
// evaluated on this very state, allocates nothing and solves for no impulse. The universal rule: p of the changed joint is E′ᵀ
// Pb, the ancestors shed or absorb Pb along the path to the root, everything else is unchanged; the next evaluation finds the
// velocities.
//
// `apply` requires a work that was evaluated on this state and this tree (call forward_dynamics first); afterwards the work is
// stale. What can't be applied is a developer's mistake and stops the program before anything has changed: a body that is not
// there, a number that is not finite, a joint that check_joint() finds fault with, and what each change says. Whoever takes
// changes from users asks before: `can_break`, `floats`, `root_of`, `Tree::alive`, `check_joint`, `check_body`.
#include <momentree/dynamics/workspace.hpp>
#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Full failure of a joint, see can_break() (paper, section 4.1): the body that carries it and all outboard ones become a
/// mechanism of their own. The ancestors shed its momentum (29); the new root's momentum is its articulated momentum; no velocity
/// changes.
struct Break {
  JointId joint;
};

/// A joint becomes another, its pose unchanged: `to`, its axes of length 1, with coordinates q.
/// Parameters are those that to.parameters says. More freedoms: no velocity changes; fewer or others: a plastic impact, p′ =
/// E′ᵀ Pb (28). Locked freedoms of the old joint are none of the new. `direction`: who is the declared child of the new joint;
/// the body that carries it (declared), that body's parent (reversed: not the ground; the joint's `at` is then in the frame of
/// the body, `child_at` in that of the parent), or that of the present joint (keep).
struct ChangeJoint {
  enum class Direction : unsigned char { keep, declared, reversed };
  JointId joint;
  Joint to;
  Values q;
  Direction direction = Direction::keep;
};

/// Freezes freedoms of a joint where they are (a bit per freedom, in the order of v), with the plastic
/// impact that takes: their momenta are dropped.
struct Lock {
  JointId joint;
  unsigned dofs = ~0u;
};
/// Lets them move again; at rest at first: p = Eᵀ Pb. No velocity changes, but for a joint whose motion is prescribed: it is
/// where and as fast as that says from now on, see SetParameters.
struct Unlock {
  JointId joint;
  unsigned dofs = ~0u;
};

/// `body` becomes the root of its free mechanism. Nothing physical changes: no pose, velocity or acceleration of any body.
struct Reroot {
  BodyId body;
};

/// The free mechanism of `body` joins `to` by a free joint at body's frame, where they are: no impulse; ancestors of `to` absorb
/// its momentum. ChangeJoint then makes the joint what it shall be: a weld, a pin (`attach` of several at one instant are one
/// impact). `to` == ground: body becomes a root on a free joint of its own, ready to be joined to the ground.
struct Join {
  BodyId body, to;
};

/// Join and ChangeJoint at once, from one evaluation: the floating mechanism of `body` hangs on `to` by `joint` at coordinates q,
/// which its placements make the present pose. Reversed: the joint's declared child is `to`. Parameters: as joint.parameters
/// says. p = E′ᵀ Pb, a plastic impact in the directions that the joint does not leave.
struct Attach {
  BodyId body, to;
  Joint joint;
  Values q;
  bool reversed = false;
};

/// An impulsive wrench on a body: world axes, force in N s at `point` (user frame of the body), torque in N m s.
struct Impulse {
  BodyId body;
  Vec3 force{}, torque{}, point{};
};

/// Impact of one freedom (in the order of v) of a joint, as against a stop: u⁺ = −restitution u⁻, by an
/// impulse along that freedom alone. The kinetic energy lost is 1 − restitution² of what a plastic impact takes. Costs an
/// evaluation.
struct Impact {
  JointId joint;
  int dof = 0;
  double restitution = 0;  ///< 0 (plastic) to 1
};

/// New parameters of a joint; velocities stay, so an armature changes p. A motion that they prescribe is
/// followed from now on, with the impulse that its speed takes (all other momenta stay), and from where it says; one that they no
/// longer prescribe leaves the joint its velocity, and p = Eᵀ Pb + armature·v.
struct SetParameters {
  JointId joint;
  JointParameters parameters;
};

/// `body` and all outboard ones leave the world: a whole mechanism that floats, `body` its root (what hangs on something is
/// broken off before). Nothing happens to the others. Their numbers are not used again; `Tree::alive` says so, any other use
/// stops the program.
struct Remove {
  BodyId body;
};

/// A new body on any living one or on the ground, with the coordinates and velocities of its spec, complete as Model::operator[]
/// has it. No velocity of another body changes. Storage grows, which may allocate: Work and integrators are to be made anew.
/// Numbers count up, so that a world that adds and removes for ever grows by some 800 bytes a body.
struct Add {
  const BodySpec* spec;
};

/// What a change let go that is not in the bodies any more: energy of the joint's spring and rotor (J).
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
/// Returns the impulse on the freedom (N s, or N m s). The topology stays.
double apply(const Impact& change, const Tree& tree, State& state, Workspace<double>& workspace) noexcept;
Released apply(const Remove& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept;
/// Returns the new body.
BodyId apply(const Add& change, Tree& tree, State& state, const Workspace<double>& workspace);

/// The same where Pb of the body's joint is given (user frame of the body), because several joints change in one impact: Pb is
/// then what it was before any of them did.
Released apply(const ChangeJoint& change, const Force<double>& Pb, Tree& tree, State& state,
               Workspace<double>& workspace) noexcept;

/// Root of the mechanism that a body belongs to.
[[nodiscard]] int root_of(const Tree& tree, int b) noexcept;
/// True for a mechanism whose root hangs on a free joint to the ground without spring, damper, friction, drive or rotor: it can
/// be re-rooted.
[[nodiscard]] bool floats(const Tree& tree, int b) noexcept;
/// True where the joint is there to be broken: not a free joint to the ground without locks and parameters.
[[nodiscard]] bool can_break(const Tree& tree, JointId joint) noexcept;

}  // namespace momentree
