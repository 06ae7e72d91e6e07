#pragma once
// Comparison of evaluations: positions and velocities to accelerations, with gravity, on the same models. To validate a timing,
// the accelerations found must balance every joint according to the Newton–Euler equations, which are implemented here
// independently.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiment.hpp"

namespace peers {

inline constexpr double gravity = -9.81;  ///< along z

/// A tree of revolute and prismatic joints: grounded, or on a free first link.
struct EvaluationModel {
  std::string name;
  std::vector<Link> links;
  bool floating() const { return links.front().free; }
};

/// An engine with a model.
class Evaluator {
 public:
  virtual ~Evaluator() = default;
  /// The timed function: from these positions and velocities (in the order of the links) until the accelerations can be read. A
  /// free link has no entries here; it is reset to its pose and velocity in the model every time.
  virtual void evaluate(const double* q, const double* u) = 0;
  /// Accelerations of the last evaluation, in the order of the links: a free link has 0 here, and six numbers at the end, the
  /// acceleration of its origin (m/s²) and its angular acceleration (rad/s²), in world axes.
  virtual std::vector<double> accelerations() = 0;
};

struct Evaluation {
  std::string name;  ///< the functions that are called
  std::function<std::unique_ptr<Evaluator>(const EvaluationModel&)> make;
  bool chains_only = false;  ///< no other models
  int most = 1 << 30;        ///< maximum number of bodies; larger models are left out
};

/// The models of these files, as `momentree bench MODEL` writes them (cli/bench/peer_links.hpp), or without files those of
/// `momentree bench`. Stops the program if a file is not a model.
std::vector<EvaluationModel> models(const std::vector<std::string>& files);

/// Times all methods of an engine on each of these models, and prints a line of JSON for each. Returns 1 if accelerations are
/// wrong.
int evaluate(const std::string& engine, const std::vector<Evaluation>& ways, const std::vector<std::string>& files);

/// The two states between which a model is moved: positions and velocities in the order of the links.
struct Turns {
  std::vector<double> q[2], u[2];
};
Turns turns_of(const EvaluationModel& model);

/// The imbalance above which accelerations are wrong. The accuracy of velocities computed from momenta decreases with a power of
/// the chain's length (README.md); a mistake causes an imbalance of order 1.
inline double allowed_imbalance(const EvaluationModel& model) { return model.links.size() <= 100 ? 1e-8 : 1e-4; }
/// Evaluations that are timed together.
inline int batch(const EvaluationModel& model) { return static_cast<int>(1 + 1000 / model.links.size()); }

bool is_chain(const EvaluationModel& model);

/// Largest imbalance of force (N m) at a joint for these accelerations, relative to the largest force that its bodies require.
/// For a free link all six components count.
double imbalance(const EvaluationModel& model, const std::vector<double>& q, const std::vector<double>& u,
                 const std::vector<double>& a);

template <class T>
std::function<std::unique_ptr<Evaluator>(const EvaluationModel&)> evaluator() {
  return [](const EvaluationModel& model) { return std::make_unique<T>(model); };
}

}  // namespace peers
