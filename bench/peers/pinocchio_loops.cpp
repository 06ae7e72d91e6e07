// Pinocchio with closed loops: constraintDynamics factorises the mass matrix together with the constraints, lcaba recurses over
// the joints with loops between them, pv and constrainedABA do so with constraints to the ground alone (they ignore a second
// body). All of them regularise constraints by μ and take as many iterations as that needs; redundant rows need μ > 0.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <type_traits>

#include <pinocchio/algorithm/constrained-dynamics.hpp>
#include <pinocchio/algorithm/loop-constrained-aba.hpp>
#include <pinocchio/algorithm/pv.hpp>

#include "loops.hpp"
#include "pinocchio_model.hpp"

namespace {

using namespace peers;

enum class Solver { constraint_dynamics, lcaba, pv, constrained_aba };

/// A model with a kind of constraint.
template <class Constraint>
struct Loops : LoopEvaluator {
  static constexpr bool rigid = std::is_same_v<Constraint, pin::RigidConstraintModel>;

  Loops(const LoopModel& m, Solver with) : solver(with), first(m.floating() ? 1 : 0), count(m.links.size()), model(m.links) {
    model.model.gravity.linear(Vector3d(0, 0, gravity));
    effort = Eigen::VectorXd::Zero(model.model.nv);
    for (int k = 0; k < 2; ++k) {
      const LoopState& from = m.states[k];
      for (std::size_t i = first; i < count; ++i) model.put(static_cast<int>(i), from.q[i], from.u[i]);
      if (first > 0) model.put(0, from.root);
      q[k] = model.q, u[k] = model.u, R[k] = from.root.R;
    }
    for (std::size_t i = 0; i < count; ++i) rows.push_back(model.row(static_cast<int>(i)));
    for (const LoopJoint& loop : m.loops) {
      const pin::SE3 own(loop.turn, loop.at), other(loop.to_turn, loop.to_at);
      const pin::JointIndex body = model.numbers[static_cast<std::size_t>(loop.body)];
      const pin::JointIndex to = loop.to < 0 ? 0 : model.numbers[static_cast<std::size_t>(loop.to)];
      if constexpr (rigid)
        constraints.emplace_back(m.planar ? pin::CONTACT_3D : pin::CONTACT_6D, model.model, body, own, to, other, pin::LOCAL);
      else
        constraints.emplace_back(model.model, body, own, to, other);
    }
    for (const Constraint& constraint : constraints) memory.emplace_back(constraint);
    if constexpr (rigid) {
      if (solver == Solver::constraint_dynamics) pin::initConstraintDynamics(model.model, *model.data, constraints, memory);
      if (solver == Solver::lcaba) pin::computeJointMinimalOrdering(model.model, *model.data, constraints);
    } else {
      pin::initPvSolver(model.model, *model.data, constraints);
    }
    choose(m);
  }

  /// The fewest iterations, then the smallest μ, with which the accelerations are right.
  void choose(const LoopModel& m) {
    double best = HUGE_VAL, best_mu = 0;
    int best_iterations = 0;
    for (const int iterations : {1, 2, 3, 4, 6, 10, 20, 40}) {
      for (const double mu : {0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1}) {
        if (mu == 0 && solver != Solver::constraint_dynamics) continue;
        settings = pin::ProximalSettings(0, 0, mu, iterations);
        const double error = worst_error(*this, m);
        if (error < best) best = error, best_mu = mu, best_iterations = iterations;
        if (error < 0.3 * allowed_error) return;
      }
    }
    settings = pin::ProximalSettings(0, 0, best_mu, best_iterations);
  }
  void evaluate(int k) override {
    last = k;
    if constexpr (rigid) {
      PINOCCHIO_COMPILER_DIAGNOSTIC_PUSH
      PINOCCHIO_COMPILER_DIAGNOSTIC_IGNORED_DEPRECECATED_DECLARATIONS
      if (solver == Solver::constraint_dynamics)
        pin::constraintDynamics(model.model, *model.data, q[k], u[k], effort, constraints, memory, settings);
      if (solver == Solver::lcaba) {
        // With welds version 4.1 reads the accelerations of the last call where it needs none.
        for (const Constraint& constraint : constraints)
          model.data->oa[constraint.joint1_id].setZero(), model.data->oa[constraint.joint2_id].setZero();
        pin::lcaba(model.model, *model.data, q[k], u[k], effort, constraints, memory, settings);
      }
      PINOCCHIO_COMPILER_DIAGNOSTIC_POP
    } else {
      if (solver == Solver::pv) pin::pv(model.model, *model.data, q[k], u[k], effort, constraints, memory, settings);
      if (solver == Solver::constrained_aba)
        pin::constrainedABA(model.model, *model.data, q[k], u[k], effort, constraints, memory, settings);
    }
  }
  std::vector<double> accelerations() override {
    const Eigen::VectorXd& found = model.data->ddq;
    std::vector<double> a;
    for (const int row : rows) a.push_back(found[row]);
    if (first == 0) return a;
    a[0] = 0;
    const Vector3d v = u[last].head<3>(), w = u[last].segment<3>(3), rate = found.head<3>();
    const Vector3d linear = R[last] * (rate + w.cross(v)), angular = R[last] * found.segment<3>(3);
    for (const Vector3d& each : {linear, angular}) a.insert(a.end(), each.data(), each.data() + 3);
    return a;
  }
  std::string note() override {
    char text[64];
    std::snprintf(text, sizeof text, "mu %g, iterations %d", settings.mu, settings.max_iter);
    return text;
  }

  Solver solver;
  std::size_t first, count;
  Model model;
  Eigen::VectorXd effort, q[2], u[2];
  Matrix3d R[2];
  std::vector<int> rows;
  std::vector<Constraint> constraints;
  std::vector<typename Constraint::ConstraintData> memory;
  pin::ProximalSettings settings;
  int last = 0;
};

template <Solver solver>
std::unique_ptr<LoopEvaluator> to_ground(const LoopModel& model) {
  if (model.planar) return std::make_unique<Loops<pin::PointAnchorConstraintModel>>(model, solver);
  return std::make_unique<Loops<pin::FrameAnchorConstraintModel>>(model, solver);
}
bool grounded(const LoopModel& model) { return model.grounded(); }

}  // namespace

std::vector<LoopWay> peers::loop_ways() {
  using Rigid = Loops<pin::RigidConstraintModel>;
  return {{"constraintDynamics", loop_evaluator<Rigid>(Solver::constraint_dynamics)},
          {"lcaba", loop_evaluator<Rigid>(Solver::lcaba)},
          {"pv", to_ground<Solver::pv>, grounded},
          {"constrainedABA", to_ground<Solver::constrained_aba>, grounded}};
}
