#pragma once
// Requirements on a joint made by a change, and its momenta.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

/// Stops the program if a change would make an invalid joint.
void require_joint(const Joint& joint, const Values& q) noexcept;

/// (28): p = E′ᵀ Pb of b's joint in its present form, at coordinates q, zero for locked DoFs; Pb in the user frame of b.
void new_joint_momenta(const Tree& tree, int b, const double* q, const Force<double>& Pb, double* p) noexcept;

/// Like apply(ChangeJoint), for several joints that change in one impact: Pb of the body's joint (user frame of the body) is its
/// value before any of these changes.
Released apply(const ChangeJoint& change, const Force<double>& Pb, Tree& tree, State& state,
               Workspace<double>& workspace) noexcept;

}  // namespace momentree
