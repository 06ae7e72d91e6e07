#pragma once
// The laws that every tree obeys at every state, measured against the oracle.
#include <cstdint>

#include <vector>

#include <momentree/dynamics/workspace.hpp>
#include <tests/oracle/oracle.hpp>

namespace momentree::oracle {

/// One law, measured.
struct Measure {
  const char* law;
  double error, bound;
  bool holds() const { return error <= bound; }  ///< not for a NaN
  double ratio() const { return bound > 0 ? error / bound : 0; }
};

struct StateMeasures {
  std::vector<Measure> laws;
  Spectrum range;
};

/// All laws at one state of a tree that stands for `system`. The work is evaluated here.
StateMeasures measure_state(const System& system, const Tree& tree, const State& state, Workspace<double>& workspace);

/// Laws of the second recursion at that state: accelerations and wrenches against the oracle's at the engine's own velocities,
/// each body's equations of motion, Eᵀ Tr = τ − rotor·v̇. The work is accelerated here; `range` is that of the mass.
/// `system` stands for the tree as it was declared: locks and re-rooting change nothing of it, but for free root joints.
std::vector<Measure> measure_accelerations(const System& system, const Tree& tree, const State& state,
                                           Workspace<double>& workspace, const Spectrum& range);
/// Newton's and Euler's equations of every body, with masses from `system`, by what the engine says of accelerations and joint
/// wrenches: the largest residual in terms of the equation's summands. Any topology. `loads`: what acts on each body from
/// outside, about its frame's origin, world axes; empty: nothing.
struct Load {
  V3<Real> force{}, torque{};
};
double equations_of_motion(const System& system, const Tree& tree, const State& state, Workspace<double>& workspace,
                           const std::vector<Load>& loads = {});
/// Eᵀ Tr against joint forces and rotors, for unlocked freedoms, in terms of the summands; columns from the oracle.
double work_of_reactions(const Tree& tree, const State& state, Workspace<double>& workspace);

/// Laws of p from velocities `given`: p = M v, and back again. `start` was made from them.
std::vector<Measure> measure_round_trip(const System& system, const std::vector<double>& given, const Tree& tree,
                                        const State& start, Workspace<double>& workspace);

/// Euclidean norms, in long double.
Real norm(const std::vector<Real>& a);
Real distance(const std::vector<Real>& a, const std::vector<Real>& b);

}  // namespace momentree::oracle
