#pragma once
// Springs between two points of bodies (Spring): their length, tension and energy.
#include <momentree/dynamics/workspace_data.hpp>

namespace momentree {

/// A spring at an instant. `direction` is the unit vector from its `from` end to its `to` end: the spring pulls `from` along it
/// with its tension, and `to` against it. It is zero if the ends coincide: the spring then has no direction and exerts no force.
struct SpringMotion {
  Vec3 from{}, to{};  ///< places of its ends in the world (m)
  Vec3 direction{};
  double length = 0;  ///< m
  double rate = 0;    ///< of the length (m/s)
};

/// Of a spring whose ends are in the world, from the poses and velocities in workspace.bodies of the bodies at its ends.
[[nodiscard]] SpringMotion spring_motion(const Tree& tree, const Workspace<double>& workspace, int spring) noexcept;

/// Energy (J) that a spring stores, zero if it does not act. Requires a workspace evaluated on this state.
[[nodiscard]] double spring_energy(const Tree& tree, const State& state, const Workspace<double>& workspace, int spring) noexcept;

/// Adds the wrenches of all springs to workspace.loads of their bodies, and what they dissipate to workspace.power. Requires
/// poses and velocities in workspace.bodies of the loaded bodies.
void add_spring_loads(const Tree& tree, Workspace<double>& workspace) noexcept;

}  // namespace momentree
