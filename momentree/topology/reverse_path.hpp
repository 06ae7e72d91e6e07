#pragma once
// The effect of re-rooting on the momenta, shared by the changes that need it.
#include <momentree/dynamics/workspace.hpp>
#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// The requirement that is reported if the mechanism does not float.
inline constexpr const char* floating =
    "the body is in the tree, and its mechanism floats: its root is joined to the ground by a bare free joint";

/// Momenta of a floating mechanism as if b were its root: changes in `p` those of the joints between its root and b, which are to
/// be reversed. Returns the momentum of the whole mechanism in the user frame of b. The tree does not change; workspace.path is
/// scratch.
Force<double> reverse_momenta(const Tree& tree, const State& state, Workspace<double>& workspace, int b, double* p) noexcept;

/// Coordinates of a free joint at a pose: position (m), then the quaternion.
inline void free_coordinates(const Pose& pose, double* q) {
  const double values[7] = {pose.position.x, pose.position.y, pose.position.z, pose.rotation.w,
                            pose.rotation.x, pose.rotation.y, pose.rotation.z};
  for (int i = 0; i < 7; ++i) q[i] = values[i];
}

}  // namespace momentree
