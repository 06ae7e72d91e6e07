#pragma once
// What the readers of a page do to a running simulation, be it of a program or of the page.
#include <memory>
#include <vector>

#include <momentree/pages/message.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

/// Sets each joint's damping to the declared one times `factor`, plus `offset` (N m s) for joints that can rotate.
std::vector<Action> scaled_damping(const World& world, double factor, double offset);
/// Sets the force at which each joint breaks (N) to the smaller one of `force` and the declared one.
std::vector<Action> limited_strength(const World& world, double force);

/// The messages act, gravity, damping, strength, grab, pull and release. A body is grabbed by a spring and a damper between a
/// point of it and the pointer, of which there is one.
class PageControls {
 public:
  /// The simulation must outlive this object and stay where it is.
  explicit PageControls(Simulation& simulation) : simulation_(simulation) {}
  /// False if the message is another.
  bool obey(Message& message);
  /// Ends the grip.
  void release();
  /// The same without a change of the simulation, which may have been restored.
  void forget() { grip_ = {}; }

 private:
  struct Grip {
    int body = -1;
    Vec3 point{};   ///< in the body's frame (m)
    Vec3 target{};  ///< in the world (m)
    double stiffness = 0, damping = 0;
    std::shared_ptr<const BodyFunction> function{};  ///< as the simulation has it
  };
  static Wrench force_of(const Grip& grip, const EvaluationContext& context);
  void apply(const std::vector<Action>& actions, Message& message);
  void grab(Message& message);
  void pull(Message& message);
  /// The function that acts on a body; null if there is none.
  std::shared_ptr<const BodyFunction> function_on(int body) const;
  /// False if the program has replaced the function that applies the grip.
  bool holds() const;
  void apply_grip();

  Simulation& simulation_;
  Grip grip_;
};

}  // namespace momentree::io
