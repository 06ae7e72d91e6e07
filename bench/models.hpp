#pragma once
// The mechanisms measured by the benchmarks and by `momentree bench`: revolute joints, gravity, light damping.
#include <momentree/model/model.hpp>

namespace momentree::bench {

/// All axes parallel, links along x.
Model planar_chain(int bodies);
/// The same on a free root: what breaks off it.
Model floating_chain(int bodies);
/// The breaking chain of Naudet and Lefeber, 2005: 100 links, at rest, curled upwards (scenarios/breaking_chain.toml).
Model breaking_chain();
/// Identical links with alternately perpendicular axes, nearly straight: 3D, but with few different placements and masses, as in
/// large worlds.
Model rope(int bodies);
/// Axes, placements, centres of mass and inertias in general position.
Model spatial_chain(int bodies);
/// The same bodies; no axis is nearly parallel to the next, which would cost a few additional operations.
Model twisted_chain(int bodies);
/// The same bodies, each on a randomly chosen earlier one: many branching nodes and leaves.
Model bushy_tree(int bodies);
/// The same bodies, two on each.
Model binary_tree(int bodies);
/// Revolute joints at right angles, as in a lightweight robot arm: the axes of shoulder, elbow and wrist meet in points 0.36,
/// 0.42, 0.40 and 0.08 m apart; repeated for more than 7 bodies.
Model arm(int bodies = 7);
/// A free pelvis and 30 revolute joints along the body's axes: two legs of 6, two arms of 7, waist and neck of 2: 31 bodies.
Model humanoid(int bodies = 31);

}  // namespace momentree::bench
