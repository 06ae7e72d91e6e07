#pragma once
// Closed loops. Between two states a loop is a set of equations φ(q) = 0 and J u = 0 beside the recursions of the tree: the
// inward pass carries the unit wrenches K of the loops' rows to the ground and gathers
//
//   k = Eᵀ K,   A += kᵀ Mj⁻¹ k,   b += kᵀ u0 + (K − G k)ᵀ a,   K_parent += Xᵀ (K − G k),
//
// where u0 = Mj⁻¹ (τ − Eᵀ W) and a is the bias of the acceleration: A = J M⁻¹ Jᵀ, and b = J u̇ without loops. After the small
// system A λ = −(b + J̇ u) is solved, Mj⁻¹ k λ is added to u0, and the outward pass of the tree gives u̇ with loops. The same
// passes with momenta in the place of forces give the velocities after an impact, and with zeros the corrections of coordinates
// and velocities.
//
// A coupling of joints is a row with an effort e instead of wrenches: 1 on the joint, −f′ on the joint that it follows. There
// k = Eᵀ K + e; everything else is the same.
//
// Redundant rows are the rule: a planar four-bar of revolute joints has 5 rows of rank 2. Rows are chosen by a pivoted
// factorisation at states, where the loops are closed, and kept for the stages of the step that follows: off the closed
// configurations the rank of some linkages (Bennett, Bricard) is larger, and an honest solution there would stop them.
#include <momentree/dynamics/motion.hpp>
#include <momentree/dynamics/workspace.hpp>
#include <momentree/model/body_force.hpp>
#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Which rows a computation uses.
enum class LoopRows : unsigned char {
  choose,  ///< as many independent ones as there are; they are kept
  kept     ///< those that were chosen last, if that was for this topology
};

/// The speeds that the armatures of loop joints have before an evaluation in momenta, whose impulses change them. The momenta of
/// a state are those of the bodies and of the tree's armatures, H u.
enum class ArmatureSpeeds : unsigned char {
  taken,  ///< those of the momenta p, which are those of a state; they are noted
  kept,   ///< those noted last
  none    ///< zero, also of prescribed motions: p are differences of momenta
};

/// Forces of springs, dampers, friction, efforts, drives and functions in loop joints at time t (s): adds them to
/// workspace.biases of both bodies, and their power to workspace.power. Requires place_loops.
void add_loop_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace) noexcept;

/// Sets the angles to which those of loop joints are nearest to the state's.
void load_turns(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// Between the inward and the outward pass of solve_accelerations, with Keep: solves for the loops' multipliers. `velocities`:
/// the passes compute velocities from momenta instead of accelerations from forces.
void solve_loops(const Tree& tree, const double* q, Workspace<double>& workspace, const Motion<double>& base, LoopRows rows,
                 bool velocities = false) noexcept;

/// The velocities that generalised impulses cause if the loops stay closed, in place: `u` holds the impulses, packed as p.
/// Requires an evaluated state at q.
void solve_with_loops(const Tree& tree, const double* q, Workspace<double>& workspace, double* u) noexcept;

/// The velocities u (nv numbers) that a unit impulse along one DoF of a loop joint causes; returns the change of the velocity of
/// that DoF. Requires an evaluated state at q.
double strike_loop(const Tree& tree, const double* q, Workspace<double>& workspace, int place, int dof, double* u) noexcept;
/// Time derivative of the velocity of a DoF of a loop joint. The same requirement.
double loop_acceleration(const Tree& tree, const double* q, const Workspace<double>& workspace, int place, int dof) noexcept;

/// The rank of the loops' rows at q, without those of armatures.
int independent_rows(const Tree& tree, double t, const double* q, Workspace<double>& workspace);

/// The impulses of a coupling on its two joints in the last change (N s or N m s). Zero if that change was no impact.
struct CouplingImpulse {
  int coupling = -1;
  double joint = 0, follows = 0;
};
CouplingImpulse coupling_impulse(const Tree& tree, const Workspace<double>& workspace, int place) noexcept;

/// The impulse through a loop joint on its declared child (N s, N m s) in the last change: about the origin `at` of the joint's
/// child-side frame, world axes. Zero if that change was no impact.
struct LoopImpulse {
  Vec3 force{}, torque{}, at{};
  double motion = 0, motion_rate = 0;  ///< of a prescribed motion along its DoF (N s, N m s), and its rate
};
LoopImpulse loop_impulse(const Tree& tree, const Workspace<double>& workspace, int place) noexcept;

/// The rows that were chosen last, in ascending order; empty without loops. After an evaluation of a state.
std::span<const int> chosen_rows(const Tree& tree, const Workspace<double>& workspace) noexcept;
/// The chosen rows, for evaluations in another workspace. Does nothing without loops.
void copy_chosen_rows(const Tree& tree, const Workspace<double>& from, Workspace<double>& to) noexcept;

/// Closes the loops after a step that ended at t (s): corrects coordinates and velocities, in place, by the least change in the
/// metric of the mass matrix. Returns false if the loops cannot be closed from there. `energy`: what the correction added (J).
/// The workspace then belongs to no state, and its chosen rows are those of the corrected coordinates.
[[nodiscard]] bool close_loops(const Tree& tree, double t, double* q, double* u, Workspace<double>& workspace,
                               double& energy) noexcept;

/// How far the loops are from a singular position, in which fewer rows are independent: the root of the least pivot of the chosen
/// rows, relative to their scales. Near such a position it is proportional to the distance. Of the last evaluation; at
/// coordinates q with the rows that are kept.
double loop_clearance(const Workspace<double>& workspace) noexcept;
double loop_clearance(const Tree& tree, const double* q, const double* u, Workspace<double>& workspace) noexcept;
/// Takes from small changes du of the velocities u at q and t (s) what the loops block, as closing them would, with the rows that
/// are kept.
void keep_loops_closed(const Tree& tree, double t, const double* q, const double* u, double* du,
                       Workspace<double>& workspace) noexcept;

/// Evaluates the state first if needed.
LoopStatus loop_status(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// Closes the loops at the start, from coordinates that may be far off; see loop_assembly.cpp. Writes the residual of each link
/// of TreeLoops::links; returns false if one cannot be closed.
[[nodiscard]] bool assemble_loops(const Tree& tree, double t, double* q, double* u, Workspace<double>& workspace,
                                  double* residuals) noexcept;
/// Moves coordinates q, with which the loops are closed, towards others as far as they stay closed and get nearer to them.
void move_loops_towards(const Tree& tree, double t, const double* other, double* q, Workspace<double>& workspace) noexcept;
/// The residual of each link at coordinates q and velocities u.
void loop_residuals(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace,
                    double* residuals) noexcept;

/// Coordinates and velocities of a loop joint (by its place in tree.loops()), which follow from the poses and velocities of its
/// bodies. Its angle is the one nearest to that at the end of the last step. Requires an evaluated state.
void loop_coordinates(const Tree& tree, const Workspace<double>& workspace, int place, double* q, double* u) noexcept;

/// The same with the values at which locked DoFs are held.
void held_loop_coordinates(const Tree& tree, const Workspace<double>& workspace, int place, double* q, double* u) noexcept;
/// The same at coordinates q and velocities u of the tree at time t (s), and State::turns(). May allocate.
void loop_joint_values(const Tree& tree, double t, const double* q, const double* u, std::span<const Turns> turns,
                       Workspace<double>& workspace, int place, double* loop_q, double* loop_u);

/// Potential energy of a loop joint's spring and soft stops (J), and kinetic energy of its armatures. The same requirement.
[[nodiscard]] double loop_energy(const Tree& tree, const Workspace<double>& workspace, int place) noexcept;
[[nodiscard]] double loop_armature_energy(const Tree& tree, const Workspace<double>& workspace, int place) noexcept;
/// Potential energy of the soft stops of all loop joints (J). The same requirement.
[[nodiscard]] double stored_in_loop_stops(const Tree& tree, const Workspace<double>& workspace) noexcept;

/// Before a change: remembers the velocities of loop joints with armature.
void carry_armatures(const Tree& tree, Workspace<double>& workspace) noexcept;

/// The prescribed motion of a loop joint; zeros without one.
struct LoopMotion {
  double effort = 0;    ///< that the motion needs beyond springs, dampers and the armature (N m, N); after an impact its impulse
  double rate = 0;      ///< m/s, rad/s
  double inertial = 0;  ///< effort that accelerates the armature (N m, N)
};
LoopMotion loop_motion(const Tree& tree, const Workspace<double>& workspace, int place) noexcept;

/// The wrench of a loop joint on its declared child, in the child's kernel frame: of the constraint alone, and with springs,
/// dampers and drives, whose effort along the DoFs is `effort`. Requires an evaluated state at that time (s).
struct LoopReaction {
  Wrench total, constraint;
  double effort[6] = {};
};
LoopReaction loop_reaction(const Tree& tree, double t, const Workspace<double>& workspace, int place) noexcept;

/// The effort of the couplings on the joint that a body carries, from the last multipliers (N m or N, or their impulses).
[[nodiscard]] double coupling_effort(const Tree& tree, const Workspace<double>& workspace, int body) noexcept;
/// Adds the efforts of all couplings for multipliers given by row, or their impulses, to joint forces packed as p; not along
/// locked and driven DoFs.
void add_coupling_efforts(const Tree& tree, const Workspace<double>& workspace, const double* multipliers,
                          double* force) noexcept;
/// The place of a coupling in TreeLoops::links; −1: it does not act.
[[nodiscard]] int coupling_place(const Tree& tree, int coupling) noexcept;

/// The largest relative velocity (m/s, rad/s) that the loops block, and whether a loop's joint is closed with its directions
/// reversed, which its equations do not exclude. After an evaluation.
double loop_velocities_open(const Tree& tree, const Workspace<double>& workspace) noexcept;
bool loop_flipped(const Tree& tree, const Workspace<double>& workspace, int place) noexcept;

/// Where the loops leave reactions open at time t (s), chooses the least ones; part of `accelerate`. Allocates at the first call
/// and where there are more redundant rows than before.
void find_least_reactions(const Tree& tree, double t, Workspace<double>& workspace);
/// The components of the reaction of a joint that the loops leave open: of a loop or a coupling, by its place in
/// TreeLoops::links, or of the inboard joint of a body. Other reactions then cause the same motion. Requires `accelerate`.
ReactionParts open_parts_of_link(const Tree& tree, const Workspace<double>& workspace, int place) noexcept;
ReactionParts open_parts_of_joint(const Tree& tree, const Workspace<double>& workspace, int body) noexcept;

}  // namespace momentree
