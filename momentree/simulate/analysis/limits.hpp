#pragma once
// What limits a configuration at rest from one side, and the projections while some of it holds: hard stops and cables.
#include <momentree/simulate/analysis/configuration.hpp>

namespace momentree::analysis {

/// A limit that is reached. It holds if it would be violated otherwise: row · a > 0.
struct Limit {
  std::vector<double> row;  ///< the rate at which displacements violate it, nv numbers
  int dof = -1;             ///< of a stop, by its place in v
  int cable = -1;           ///< of a taut cable, by its number among the springs
};

/// The limits that hold, and the projection P of displacements onto those that they, locks and loops allow, which is that of
/// accelerations, too: Gauss' principle.
struct Held {
  std::vector<Limit> limits;
  DenseMatrix P;
};
/// Of accelerations without them. A limit is released if it would have to pull.
[[nodiscard]] Held find_held(Configuration& at_rest, const std::vector<double>& a);
/// The accelerations at another configuration while the same limits hold.
[[nodiscard]] std::vector<double> held_accelerations(Configuration& at_rest, const Held& held);

/// The part of a displacement until the next limit that does not hold yet, at most 1.
[[nodiscard]] double part_to_limits(Configuration& at_rest, const std::vector<double>& step);
/// A cable that is longer than it can be, by its number among the springs; −1: none.
[[nodiscard]] int stretched_cable(Configuration& at_rest);
/// Shortens cables that are too long by rounding, or by the curvature of a displacement. False if that is impossible.
[[nodiscard]] bool shorten_cables(Configuration& at_rest);

}  // namespace momentree::analysis
