#pragma once
// Compares the dynamics of two models of the same bodies at random states.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <momentree/dynamics/acceleration.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <tests/oracle/random_model.hpp>

namespace momentree::oracle {

/// A model at a state, with its accelerations.
struct Evaluated {
  Tree tree;
  State state;
  Workspace<double> workspace;
  Evaluated(const Model& model, double time) : tree(model), state(start_state(model, tree)), workspace(tree) {
    state.edit().time = time;
    locate_bodies(tree, state, workspace);
    accelerate(tree, state, workspace);
  }
};

/// The same bodies at another state; joints with prescribed motion keep their positions.
inline Model at_state(const Model& model, const std::vector<Values>& q, const std::vector<Values>& v) {
  Model moved({.gravity = model.gravity()});
  for (int b = 0; b < model.size(); ++b) {
    BodySpec spec = model[BodyId{b}];
    const auto i = static_cast<std::size_t>(b);
    const bool driven = spec.joint.parameters.drive && spec.joint.parameters.drive->moves();
    if (!driven) spec.q = q[i], spec.v = v[i];
    moved.add_unjudged(spec);
  }
  for (const BodyForce& force : model.forces()) moved.add_force(force);
  return moved;
}

struct RandomState {
  std::vector<Values> q, v;
  double time;
};
inline RandomState random_state(const Model& model, Prng& random) {
  RandomState state;
  for (const BodySpec& spec : model.bodies()) {
    state.q.push_back(random_coordinates(random, spec.joint.kind));
    const JointLimits& limits = spec.joint.parameters.limits;
    Values& q = state.q.back();
    for (int i = 0; limits.hard() && i < q.size(); ++i)  // no state is beyond a hard stop
      q[i] = random.uniform(std::max(limits.lower_of(i), -3.0), std::min(limits.upper_of(i), 3.0));
    state.v.push_back(random_velocities(random, spec.joint.kind));
  }
  state.time = random.uniform(0, 2);
  return state;
}

/// Largest difference of joint accelerations and momentum rates, relative to the largest of each, between two models with the
/// same joints in the same order.
inline double difference(const Model& one, const Model& other, const RandomState& at) {
  const Evaluated a(at_state(one, at.q, at.v), at.time), b(at_state(other, at.q, at.v), at.time);
  const auto compare = [](const std::vector<double>& x, const std::vector<double>& y) {
    if (x.size() != y.size()) return HUGE_VAL;
    double worst = 0, largest = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (!std::isfinite(x[i]) || !std::isfinite(y[i])) return HUGE_VAL;
      worst = std::max(worst, std::fabs(x[i] - y[i]));
      largest = std::max(largest, std::fabs(x[i]));
    }
    return worst == 0 ? 0 : worst / largest;
  };
  const auto array = [](const Evaluated& e, const Workspace<double>::Array& x) {
    return std::vector<double>(x.get(), x.get() + e.tree.nv());
  };
  return std::max(compare(array(a, a.workspace.a), array(b, b.workspace.a)),
                  compare(array(a, a.workspace.pdot), array(b, b.workspace.pdot)));
}

}  // namespace momentree::oracle
