#pragma once
// Write access to a world, for what runs it: simulations, the operations of actions, stops and contacts.
#include <span>
#include <utility>
#include <vector>

#include <momentree/simulate/world/world.hpp>

namespace momentree {

/// The parts of a world as they are stored: whoever changes one of them keeps the others in step.
class World::Edit {
 public:
  explicit Edit(World& world) : world_(world) {}

  Tree& tree() const { return world_.tree_; }
  State& state() const { return world_.state_; }
  Workspace<double>& workspace() const { return world_.workspace_; }
  Names& names() const { return world_.names_; }
  WorldStart& start() const { return world_.start_; }
  WorldConstraints& constraints() const { return world_.constraints_; }
  /// Of the present tree.
  const Connections& connections() const { return world_.connections(); }
  void evaluate() const { world_.evaluate(); }

  BodyId add(BodySpec spec, std::vector<contact::Solid> collision) const {
    return world_.add(std::move(spec), std::move(collision));
  }
  void remove(BodyId body) const { world_.remove(body); }
  /// Sets the function that drives a joint, or that acts on a body; an empty one removes it.
  void drive(int joint, JointFunction function) const { world_.drive(joint, std::move(function)); }
  void load(int body, BodyFunction function) const { world_.load(body, std::move(function)); }
  void set_gravity(Vec3 gravity) const { world_.set_gravity(gravity); }
  /// Corrects the clock; driven joints follow.
  void set_time(double time) const { world_.set_time(time); }
  /// Sets the state, as Simulation::set_state(). Throws Error, with nothing changed.
  void set_values(double time, std::span<const double> q, std::span<const double> y, Variables given) const {
    world_.set_values(time, q, y, given);
  }
  /// The same motion in other variables, or in those that its topology asks for.
  void take_variables(Variables variables) const { world_.take_variables(variables); }
  // After a snapshot of a world whose method takes velocities, where the method takes momenta alone.
  void take_needed_variables() const {
    if (world_.own_variables() == Variables::momenta) world_.take_variables(Variables::momenta);
  }
  void take_own_variables() const { world_.take_variables(world_.own_variables()); }
  /// Active limits end when their joint, or its limits, are removed.
  void forget_active_limits() const { world_.forget_active_limits(); }

 private:
  World& world_;
};

inline World::Edit World::edit() { return Edit(*this); }

}  // namespace momentree
