#pragma once
// Evaluations with closed loops: from positions and velocities to accelerations, with gravity. The accelerations found are
// compared with those of a dense solution, implemented here for this purpose (loop_oracle.cpp).
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "evaluation.hpp"

namespace peers {

/// A joint that closes a loop between two bodies, or a body and the ground (`to` = −1): a frame on each of them. Of a planar
/// mechanism it holds the origins together (its axis of rotation is z of both frames); otherwise it holds the frames together.
struct LoopJoint {
  int body, to = -1;
  Matrix3d turn = Matrix3d::Identity(), to_turn = Matrix3d::Identity();
  Vector3d at = Vector3d::Zero(), to_at = Vector3d::Zero();
};

/// Angles and rates of the joints in the order of the links, and the motion of a free root.
struct LoopState {
  std::vector<double> q, u;
  Motion root;
};

struct LoopModel {
  std::string name;
  std::vector<Link> links;
  std::vector<LoopJoint> loops;
  bool planar;                      ///< loop joints are pins, else welds
  LoopState states[2];              ///< closed, with velocities that keep the loops closed
  std::vector<double> expected[2];  ///< accelerations there, in the order of Evaluator::accelerations
  bool floating() const { return links.front().free; }
  bool grounded() const;  ///< all loop joints are between a body and the ground
};
std::vector<LoopModel> loop_models();

/// Completes a model: closes its loops at the state nearest to states[0].q and near it at a second one, draws velocities, and
/// finds the accelerations. Stops the program if loops can't be closed. Welds hold their bodies as these stand in states[0].
void complete(LoopModel& model);

/// An engine with a model.
class LoopEvaluator {
 public:
  virtual ~LoopEvaluator() = default;
  /// The timed function: from the coordinates and velocities of that state until the accelerations can be read.
  virtual void evaluate(int state) = 0;
  /// Of the last evaluation, as Evaluator::accelerations.
  virtual std::vector<double> accelerations() = 0;
  /// Settings with which the engine solves this model.
  virtual std::string note() { return {}; }
};

struct LoopWay {
  std::string name;  ///< the functions that are called
  std::function<std::unique_ptr<LoopEvaluator>(const LoopModel&)> make;
  std::function<bool(const LoopModel&)> fits = [](const LoopModel&) { return true; };
};

/// The largest error of the accelerations in both states, relative to the largest acceleration.
double worst_error(LoopEvaluator& engine, const LoopModel& model);
inline constexpr double allowed_error = 1e-9;

/// Times all methods of an engine on each model whose name contains `only`, and prints a line of JSON for each. Returns 1 if
/// accelerations are wrong.
int evaluate_loops(const std::string& engine, const std::vector<LoopWay>& ways, const std::string& only);

/// The methods of the engine in whose program this is called: ENGINE_loops.cpp.
std::vector<LoopWay> loop_ways();

template <class T, class... Arguments>
std::function<std::unique_ptr<LoopEvaluator>(const LoopModel&)> loop_evaluator(Arguments... arguments) {
  return [=](const LoopModel& model) { return std::make_unique<T>(model, arguments...); };
}

}  // namespace peers
