#pragma once
// Topology changes against an independent projection: in maximal coordinates (velocities of all bodies, mass-weighted), with
// constraints derived only from the oracle's forward kinematics.
#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/topology/change.hpp>
#include <tests/oracle/oracle.hpp>
#include <tests/oracle/random_model.hpp>

namespace momentree::oracle {

using Dense = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using Column = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

/// A model with its tree, state and workspace, in maximal coordinates. Evaluate before the queries.
struct Machine {
  Model model;
  Tree tree;
  State state;
  Workspace<double> workspace;
  explicit Machine(const Model& m) : model(m), tree(model), state(start_state(model, tree)), workspace(tree) { evaluate(); }
  void evaluate() { locate_bodies(tree, state, workspace); }
  int size() const { return tree.bodies(); }

  /// A random body that has not been removed.
  int some_body(Prng& random) const;
  /// Number of bodies outboard of b, including b.
  int part(int b) const;
  /// Adds a body to a random body or to the ground, and returns its number; evaluate afterwards.
  int add(Prng& random, bool parameters, bool at_rest);

  Pose pose(int b) const { return user_pose(tree, workspace.bodies[static_cast<std::size_t>(b)], b); }
  /// Velocities of the centres of mass and angular velocities, world axes.
  Column velocities() const;
  Dense masses() const;
  /// Rows C with C V = 0 for the present joints: the motions of the declared child relative to its parent that are not allowed.
  Dense constraints() const;
};

/// V after the plastic impact onto C V = 0.
Column projected(const Dense& M, const Dense& C, const Column& V);
inline long double energy(const Dense& M, const Column& V) { return V.dot(M * V) / 2; }

/// Some DoFs out of `nv`, at least one.
unsigned some_dofs(Prng& random, int nv);

/// A joint of a random kind at the present pose of b, with its frame at the declared child's; the declared child is b, its
/// parent, or the present one.
ChangeJoint random_change(Prng& random, const Machine& m, int b, ChangeJoint::Direction direction = ChangeJoint::Direction::keep);

/// A joint of a random kind between mechanisms in their present poses; declared either way.
Attach random_attach(Prng& random, const Machine& m, int b, int to);
/// One random change of any kind to an evaluated machine, which is evaluated afterwards; some machines allow none.
void act(Prng& random, Machine& m);

/// Condition of the joint-space mass, for unit directions that the constraints leave free: the accuracy of velocities.
double condition(const Dense& M, const Dense& C);

struct Outcome {
  long double difference = 0, gain = 0, carnot = 0;
  double bound = 0;  ///< for the difference: round-off of the state, amplified by the condition of the mass matrix
};

/// Calls `act` on the machine and compares with the projection onto the machine's constraints afterwards.
template <class Act>
Outcome compare(Machine& m, Act act) {
  m.evaluate();
  const Column before = m.velocities();
  act();
  m.evaluate();
  const Dense M = m.masses(), C = m.constraints();
  const Column expected = projected(M, C, before), after = m.velocities();
  const long double scale = std::max<long double>(before.cwiseAbs().maxCoeff(), 1);
  const Column jump = after - before;
  const long double T0 = energy(M, before), T1 = energy(M, after);
  return {(after - expected).cwiseAbs().maxCoeff() / scale, (T1 - T0) / std::max<long double>(T0, 1e-30L),
          std::fabs(T0 - T1 - energy(M, jump)) / std::max<long double>(T0, 1e-30L),
          std::max(1e-10, 10 * 2.2e-16 * condition(M, C))};
}

}  // namespace momentree::oracle
