#pragma once
// Topology changes against an independent projection: in maximal coordinates (velocities of all bodies, mass-weighted), with
// constraints from the oracle's forward kinematics alone.
#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/topology/change.hpp>
#include <tests/oracle/oracle.hpp>
#include <tests/oracle/random_model.hpp>

namespace momentree::oracle {

using Dense = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using Column = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

/// A model with its tree, state and work, seen in maximal coordinates. Evaluate before the queries.
struct Machine {
  Model model;
  Tree tree;
  State state;
  Workspace<double> workspace;
  explicit Machine(const Model& m) : model(m), tree(model), state(start_state(model, tree)), workspace(tree) { evaluate(); }
  void evaluate() { locate_bodies(tree, state, workspace); }
  int size() const { return tree.bodies(); }

  /// A living body.
  int some_body(Prng& random) const;
  /// Bodies outboard of b and b itself.
  int part(int b) const;
  /// A new body on any or on the ground, which it returns; evaluate afterwards.
  int add(Prng& random, bool parameters, bool at_rest);

  Pose pose(int b) const { return user_pose(tree, workspace.bodies[static_cast<std::size_t>(b)], b); }
  /// Velocities of the centres of mass and angular velocities, world axes.
  Column velocities() const;
  Dense masses() const;
  /// Rows C with C V = 0 for the joints as they are: what the declared child may not do relative to its parent.
  Dense constraints() const;
};

/// V after the plastic impact onto C V = 0.
Column projected(const Dense& M, const Dense& C, const Column& V);
inline long double energy(const Dense& M, const Column& V) { return V.dot(M * V) / 2; }

/// Some freedoms out of `nv`, at least one.
unsigned some_dofs(Prng& random, int nv);

/// A joint of a random kind at the present pose of b, its frame at the declared child's own; for a declared child that is b, its
/// parent, or what it is at present.
ChangeJoint random_change(Prng& random, const Machine& m, int b, ChangeJoint::Direction direction = ChangeJoint::Direction::keep);

/// A joint of a random kind between mechanisms, where the bodies are; declared either way.
Attach random_attach(Prng& random, const Machine& m, int b, int to);
/// One random change of any kind of an evaluated machine, evaluated afterwards; some allow nothing.
void act(Prng& random, Machine& m);

/// Condition of the joint-space mass, in directions of length one that the constraints leave: what velocities can be known to.
double condition(const Dense& M, const Dense& C);

struct Outcome {
  long double difference = 0, gain = 0, carnot = 0;
  double bound = 0;  ///< for the difference: round-off in the state, carried by the condition of the mass matrix
};

/// Runs `act` on the machine and compares with the projection onto the constraints that the machine has afterwards.
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
