#pragma once
// Evaluations side by side: positions and velocities of pins to their accelerations, with gravity, on the same models. Before a
// time is believed, the accelerations found must balance every joint: by Newton's and Euler's laws, written here for that alone.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiment.hpp"

namespace peers {

inline constexpr double gravity = -9.81;  ///< along z

/// A grounded tree of pins.
struct EvaluationModel {
  std::string name;
  std::vector<Link> links;
};

/// An engine with a model.
class Evaluator {
 public:
  virtual ~Evaluator() = default;
  /// What is timed: from these positions and velocities (in the order of the links) until the accelerations can be read.
  virtual void evaluate(const double* q, const double* u) = 0;
  /// Those of the last evaluation.
  virtual std::vector<double> accelerations() = 0;
};

struct Evaluation {
  std::string name;  ///< the calls that are made
  std::function<std::unique_ptr<Evaluator>(const EvaluationModel&)> make;
  int most = 1 << 30;  ///< bodies; larger models are left out
};

/// Times the ways of an engine on every model, and prints a line of JSON for each. Returns 1 where accelerations are wrong.
int evaluate(const std::string& engine, const std::vector<Evaluation>& ways);

/// Largest force (N m) that is missing at a joint for these accelerations, as a share of the largest that its bodies take.
double imbalance(const EvaluationModel& model, const std::vector<double>& q, const std::vector<double>& u,
                 const std::vector<double>& a);

template <class T>
std::function<std::unique_ptr<Evaluator>(const EvaluationModel&)> evaluator() {
  return [](const EvaluationModel& model) { return std::make_unique<T>(model); };
}

}  // namespace peers
