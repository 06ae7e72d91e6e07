#pragma once
// Changes of a state in velocities. Every body keeps its own momentum up to the impulses of the joints; the velocities after the
// change are its projection onto the new joints, p′ = E′ᵀ P as in momenta, but without the digits that long chains lose there.
// Where DoFs are only added, velocities stay.
#include <momentree/dynamics/velocity.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

inline bool in_velocities(const State& state) { return state.variables() == Variables::velocities; }

/// Stores the momentum of every body about its centre of mass, in the axes of its user frame: call before the tree changes, on an
/// evaluated workspace.
void carry_momenta(const Tree& tree, Workspace<double>& workspace) noexcept;

/// After the change: replaces the velocities of the mechanism of body b by the projection of the momenta carried. In the state: u
/// of DoFs whose armature keeps turning, the rates of driven DoFs; zeros for other DoFs that the change made.
void settle_velocities(const Tree& tree, State& state, Workspace<double>& workspace, int b) noexcept;

/// Velocity of body b in its user frame; that of the ground is zero.
Motion<double> user_velocity(const Tree& tree, const Workspace<double>& workspace, int b) noexcept;

/// Velocities u of b's present joint at its coordinates q for which b and its parent move like that, in their user frames; the
/// joint must allow this motion.
void joint_velocities(const Tree& tree, int b, const double* q, const Motion<double>& own, const Motion<double>& outer,
                      double* u) noexcept;

}  // namespace momentree
