#pragma once
// Where a world is at rest, and how it vibrates about that.
#include <momentree/simulate/world/world.hpp>

namespace momentree {

/// An undamped mode of vibration about a configuration at rest.
struct Mode {
  double square = 0;          ///< ω² (1/s²); negative: it moves away, at a rate √−ω²
  std::vector<double> shape;  ///< displacement of the DoFs, in the order of v; shapeᵀ M shape = 1
  /// Natural frequency (Hz); zero if it does not vibrate.
  double frequency() const;
};

/// A configuration in which all forces balance.
struct Equilibrium {
  std::vector<double> q;  ///< in the order of State::q()
  double residual = 0;    ///< the largest remaining acceleration (rad/s², m/s²)
  int iterations = 0;
  std::vector<Mode> modes;   ///< ascending in ω²; without DoFs that are held or rest on stops
  std::vector<int> resting;  ///< DoFs that hard stops hold, by their places in v
  std::vector<int> taut;     ///< cables that hold, by their numbers among the springs
  /// No mode moves away. Modes with ω² = 0 within rounding are neutral: the configuration can be displaced along them.
  bool stable() const;
};

/// The joint of a DoF, given by its place in v.
[[nodiscard]] JointId joint_of_dof(const Tree& tree, int dof);

/// The equilibrium that the world reaches from its present configuration in a viscous fluid, without inertia; where it starts in
/// one, that one, stable or not. Closed loops stay closed, hard stops are not passed, cables are not stretched, and drives have
/// their values at the present time. The world is not changed. Throws Error if there is none within reach, as for bodies that
/// fall freely, and for worlds in which bodies can touch or a cable is taut since the last run.
[[nodiscard]] Equilibrium equilibrium(const World& world);

}  // namespace momentree
