#pragma once
// The measurement of every engine: one newly made Trial per repetition.
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "experiment.hpp"

namespace peers {

/// An engine with an experiment's bodies in their initial state.
class Trial {
 public:
  virtual ~Trial() = default;
  /// The timed change, until its velocities can be read.
  virtual void change() = 0;
  /// Continues the simulation if the change needs time to act; not timed.
  virtual void settle() {}
  /// Simulated time since the start (s): zero if the change is instantaneous.
  virtual double elapsed() const { return 0; }
  /// The present motion of the bodies in the engine, in the experiment's order.
  virtual std::vector<Motion> motions() = 0;
};

struct Way {
  std::string name;  ///< the functions that are called: "BodyNode::split<FreeJoint>"
  std::string note;
  std::function<std::unique_ptr<Trial>(const Experiment&)> make;
};

/// How far bodies are from where the change should have left them; see README.md.
struct Judgement {
  double linear, angular, energy, exact_loss, position, velocity;
};
/// `after`: the motions found, `elapsed` (s) after the start.
Judgement judge(const Experiment& experiment, const std::vector<Motion>& after, double elapsed);

/// Largest deviation of these motions from the start of the experiment, and the body that has it.
std::pair<double, std::size_t> off_start(const Experiment& experiment, const std::vector<Motion>& found);

/// Prints a line of JSON. Stops the program if the engine's bodies do not start as in the experiment.
void measure(const std::string& engine, const Experiment& experiment, const Way& way);

/// The methods with which an engine can make a change.
using Ways = std::function<std::vector<Way>(Change)>;
/// Runs every experiment with an engine.
int run(const std::string& engine, const Ways& ways);

template <class T, class... Arguments>
std::function<std::unique_ptr<Trial>(const Experiment&)> maker(Arguments... arguments) {
  return [=](const Experiment& experiment) { return std::make_unique<T>(experiment, arguments...); };
}

}  // namespace peers
