#pragma once
// A world of a batch that is stepped by a simulation of its own.
#include <span>
#include <string>
#include <vector>

#include <momentree/batch/group.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {

struct BatchOptions;

namespace batch {

/// How the simulations of a batch's worlds are integrated. Throws Error for a method that is not one of contact.
Integration integration_of(const Model& model, const BatchOptions& options);

/// The topology of a world as groups have it: without closed contacts and functions, and with joints that rest on stops free.
Topology bare_topology(const World& world);

class SimulatedWorld {
 public:
  SimulatedWorld(const Model& model, const Integration& integration);

  Simulation& simulation() { return simulation_; }
  const Simulation& simulation() const { return simulation_; }
  /// The batch's state or topology of the world is not that of the simulation.
  bool is_changed() const { return changed_; }
  void changed() { changed_ = true; }
  /// Restarts the simulation at that world.
  void restart(const WorldSnapshot& start, const Model& model);
  /// Extra efforts act from now on.
  void set_efforts(std::span<const ExtraEffort> efforts);
  /// What is done with the simulation next.
  enum class Use : unsigned char { step, read };
  /// Prepares the simulation for steps and actions, or for reading its contacts, after restart() if the world was changed.
  void prepare(Use use);
  /// Steps the world by h seconds. Returns why that was impossible, empty: it was possible.
  std::string step(double h);
  /// Compares its topology with that of its group. True: the world belongs to another group.
  bool left(const Topology& group, const Tree& declared);
  /// The topology that left() found.
  const Topology& topology() const { return topology_; }
  /// Events since the last step began.
  std::span<const Event> events() const { return std::span(simulation_.events()).subspan(first_event_); }

  std::string message;      ///< why its last step was impossible
  bool made_loops = false;  ///< the number of the next loop joint depends on earlier ones
  bool moves = false;       ///< in the present step it has left its group

 private:
  JointFunction function_of(int joint) const;

  Simulation simulation_;
  bool changed_ = false;
  bool efforts_changed_ = false;  // since the last step
  std::size_t first_event_ = 0;   // of the last step
  std::uint64_t compared_ = 0;    // the revision of the tree for which the topology is that of the group
  Topology topology_;
  std::vector<ExtraEffort> efforts_;
  std::vector<double> by_joint_;  // the same, six numbers for each joint; never resized, since functions read them
};

}  // namespace batch
}  // namespace momentree
