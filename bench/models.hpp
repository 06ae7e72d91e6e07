#pragma once
// The mechanisms that are measured: pin joints, fixed root, gravity on, gently damped.
#include <momentree/tree/model.hpp>

namespace momentree::bench {

/// All axes parallel, links along x: the breaking chain.
Model planar_chain(int bodies);
/// Axes, placements, centres of mass and inertias in general position.
Model spatial_chain(int bodies);
/// The same bodies, each on a randomly chosen earlier one: many forks and tips.
Model bushy_tree(int bodies);
/// A floating trunk with a neck, two arms and two legs: 30 pins along x, y, z of their parents; `bodies` is 31.
Model humanoid(int bodies);

}  // namespace momentree::bench
