#pragma once
// Forces on bodies (BodyForce, Spring) in both recursions. They may depend on velocities, which are known only after the forward
// recursion. So they are added by a separate inward pass, Tb = T + Σ Xᵀ Tb_child, ṗ += Eᵀ Tb, restricted to the paths from the
// loaded bodies to their roots.
#include <momentree/dynamics/workspace_data.hpp>

namespace momentree {

/// Adds the effect of forces on bodies at time t (s) to pdot, and their power to workspace.power: that of drag and of springs
/// is dissipated, that of force and torque is work. Stores T of each loaded body in workspace.loads. Call after evaluate_rates or
/// evaluate_motions at q, and after add_joint_forces. Neither allocates nor throws; does nothing if there are no forces.
void add_body_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace) noexcept;

/// Stores T of each loaded body in workspace.loads and adds the power, for the velocities in workspace.v.
void find_loads(const Tree& tree, double t, const double* q, Workspace<double>& workspace) noexcept;

/// Zeroes workspace.loads of the bodies without forces, in a tree with forces, as the second recursion needs.
void clear_other_loads(const Tree& tree, Workspace<double>& workspace) noexcept;

}  // namespace momentree
