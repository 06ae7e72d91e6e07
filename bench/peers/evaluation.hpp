#pragma once
// Evaluations side by side: positions and velocities to accelerations, with gravity, on the same models. Before a time is
// believed, the accelerations found must balance every joint: by Newton's and Euler's laws, written here for that alone.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiment.hpp"

namespace peers {

inline constexpr double gravity = -9.81;  ///< along z

/// A tree of pins and slides: grounded, or on a first link that is free.
struct EvaluationModel {
  std::string name;
  std::vector<Link> links;
  bool floating() const { return links.front().free; }
};

/// An engine with a model.
class Evaluator {
 public:
  virtual ~Evaluator() = default;
  /// What is timed: from these positions and velocities (in the order of the links) until the accelerations can be read. A free
  /// link has none of its own here, and is put where the model has it, at its velocity, every time.
  virtual void evaluate(const double* q, const double* u) = 0;
  /// Those of the last evaluation, in the order of the links: a free one has 0 here, and six at the end, the acceleration of its
  /// origin (m/s²) and its angular acceleration, along the world's axes.
  virtual std::vector<double> accelerations() = 0;
};

struct Evaluation {
  std::string name;  ///< the calls that are made
  std::function<std::unique_ptr<Evaluator>(const EvaluationModel&)> make;
  bool chains_only = false;  ///< no other models
  int most = 1 << 30;        ///< bodies; larger models are left out
};

/// The models of these files, as `momentree bench MODEL` writes them (cli/peer_links.hpp), or, where there are none, those of
/// `momentree bench`. Stops the program where a file is none.
std::vector<EvaluationModel> models(const std::vector<std::string>& files);

/// Times the ways of an engine on every one of these models, and prints a line of JSON for each. Returns 1 where accelerations
/// are wrong.
int evaluate(const std::string& engine, const std::vector<Evaluation>& ways, const std::vector<std::string>& files);

/// Largest force (N m) that is missing at a joint for these accelerations, as a share of the largest that its bodies take. What
/// a free link is missing counts all six.
double imbalance(const EvaluationModel& model, const std::vector<double>& q, const std::vector<double>& u,
                 const std::vector<double>& a);

template <class T>
std::function<std::unique_ptr<Evaluator>(const EvaluationModel&)> evaluator() {
  return [](const EvaluationModel& model) { return std::make_unique<T>(model); };
}

}  // namespace peers
