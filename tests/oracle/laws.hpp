#pragma once
// Laws that hold for every tree at every state, measured against the oracle.
#include <cstdint>

#include <vector>

#include <momentree/dynamics/workspace.hpp>
#include <tests/oracle/oracle.hpp>

namespace momentree::oracle {

/// The measured error of one law.
struct Measure {
  const char* law;
  double error, bound;
  bool holds() const { return error <= bound; }  ///< false for NaN
  double ratio() const { return bound > 0 ? error / bound : 0; }
};

struct StateMeasures {
  std::vector<Measure> laws;
  Spectrum range;
};

/// All laws at one state of a tree that represents `system`. Evaluates the workspace.
StateMeasures measure_state(const System& system, const Tree& tree, const State& state, Workspace<double>& workspace);

/// Laws of the second recursion at that state: accelerations and wrenches against the oracle's at the engine's own velocities,
/// each body's equations of motion, Eᵀ Tr = τ − armature·v̇. Computes the workspace's accelerations; `range` is that of the mass.
/// `system` is the tree as declared: locks and re-rooting do not affect it, except for free root joints.
std::vector<Measure> measure_accelerations(const System& system, const Tree& tree, const State& state,
                                           Workspace<double>& workspace, const Spectrum& range);
/// Newton–Euler equations of every body, with masses from `system` and the engine's accelerations and joint wrenches: the largest
/// residual relative to the equation's summands. For any topology. `loads`: external forces on each body about its frame's
/// origin, world axes; empty: none.
struct Load {
  V3<Real> force{}, torque{};
};
double equations_of_motion(const System& system, const Tree& tree, const State& state, Workspace<double>& workspace,
                           const std::vector<Load>& loads = {});
/// Eᵀ Tr against joint forces and armature, for unlocked DoFs, relative to the summands; columns from the oracle.
double work_of_reactions(const Tree& tree, const State& state, Workspace<double>& workspace);

/// Laws for p computed from velocities `given`: p = M v, and back again. `start` was made from these velocities.
std::vector<Measure> measure_round_trip(const System& system, const std::vector<double>& given, const Tree& tree,
                                        const State& start, Workspace<double>& workspace);

/// Euclidean norms, in long double.
Real norm(const std::vector<Real>& a);
Real distance(const std::vector<Real>& a, const std::vector<Real>& b);

}  // namespace momentree::oracle
