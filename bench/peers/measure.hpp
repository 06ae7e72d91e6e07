#pragma once
// How every engine is measured: one Trial per repetition, made afresh.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiment.hpp"

namespace peers {

/// An engine with an experiment's bodies in their start state.
class Trial {
 public:
  virtual ~Trial() = default;
  /// The change, until its velocities can be read: what is timed.
  virtual void change() = 0;
  /// Simulates on, where the change needs time to act; not timed.
  virtual void settle() {}
  /// How far the world has been simulated since the start (s): zero where the change is one of an instant.
  virtual double elapsed() const { return 0; }
  /// The bodies as the engine has them now, in the experiment's order.
  virtual std::vector<Motion> motions() = 0;
};

struct Way {
  std::string name;  ///< the calls that are made: "BodyNode::split<FreeJoint>"
  std::string note;
  std::function<std::unique_ptr<Trial>(const Experiment&)> make;
};

/// Prints a line of JSON. Stops the program where the engine's bodies do not start as the experiment says.
void measure(const std::string& engine, const Experiment& experiment, const Way& way);

/// The ways of an engine to make a change.
using Ways = std::function<std::vector<Way>(Change)>;
/// Puts an engine to every experiment.
int run(const std::string& engine, const Ways& ways);

template <class T, class... Arguments>
std::function<std::unique_ptr<Trial>(const Experiment&)> maker(Arguments... arguments) {
  return [=](const Experiment& experiment) { return std::make_unique<T>(experiment, arguments...); };
}

}  // namespace peers
