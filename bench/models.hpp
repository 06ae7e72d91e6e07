#pragma once
// The mechanisms that are measured, by the benchmarks and by `momentree bench`: pin joints, gravity on, gently damped.
#include <momentree/tree/model.hpp>

namespace momentree::bench {

/// All axes parallel, links along x.
Model planar_chain(int bodies);
/// The breaking chain of Naudet and Lefeber, 2005: 100 links, at rest, curled upwards (scenarios/breaking_chain.toml).
Model breaking_chain();
/// Equal links with axes across each other in turn, nearly straight: 3D, but few placements and masses, as large worlds have
/// them.
Model rope(int bodies);
/// Axes, placements, centres of mass and inertias in general position.
Model spatial_chain(int bodies);
/// The same bodies; no axis is nearly parallel to the next, which would cost a few operations more.
Model twisted_chain(int bodies);
/// The same bodies, each on a randomly chosen earlier one: many forks and tips.
Model bushy_tree(int bodies);
/// The same bodies, two on each.
Model binary_tree(int bodies);
/// Pins at right angles, as in an arm for light work: shoulder, elbow and wrist meet in points, 0.36, 0.42, 0.40 and 0.08 m
/// apart, over and over for more than 7.
Model arm(int bodies = 7);
/// Free pelvis, and 30 pins along the axes of the body: two legs of 6, two arms of 7, waist and neck of 2: 31 bodies.
Model humanoid(int bodies = 31);

}  // namespace momentree::bench
