#pragma once
// Forces on bodies (BodyForce) in the two recursions. They need velocities, which are known after the forward recursion only, so
// they come in by an inward sweep of their own: Tb = T + Σ Xᵀ Tb of the children, ṗ += Eᵀ Tb, along the paths from the loaded
// bodies to their roots and nowhere else.
#include <momentree/dynamics/workspace.hpp>

namespace momentree {

/// Adds to pdot what forces on bodies do at time t, and their power to work.power: what drag takes is dissipated, what force and
/// torque give is work. Keeps T of each loaded body in work.loads. After evaluate_rates or evaluate_motions at q, and after
/// add_joint_forces. Neither allocates nor throws; nothing to do where there are none.
void add_body_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace) noexcept;

/// Of bodies on which no force acts, in a tree where some do: zeros in work.loads, as the second recursion wants.
void clear_other_loads(const Tree& tree, Workspace<double>& workspace) noexcept;

}  // namespace momentree
