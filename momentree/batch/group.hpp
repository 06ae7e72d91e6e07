#pragma once
// The worlds of a batch with one topology, packed into blocks of lanes.
#include <optional>
#include <span>
#include <vector>

#include <momentree/batch/stepper.hpp>
#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree::batch {

/// Equal topologies have equal keys; different ones may, too.
std::size_t key_of(const Topology& topology) noexcept;
bool same(const Topology& a, const Topology& b) noexcept;
bool same_pose(const Pose& a, const Pose& b) noexcept;
/// Removes changes that restored declared joints, which are those of `declared`.
void simplify(Topology& topology, const Tree& declared);
/// A feature of the tree that worlds in lanes do not have. Contacts are no features of trees.
struct Unsupported {
  const char *problem, *hint;
};
std::optional<Unsupported> unsupported(const Tree& tree) noexcept;
/// Throws Error if there is one.
void check(const Tree& tree);
/// Throws Error if functions drive joints or act on bodies.
void check_functions(const Tree& tree);

/// An extra effort of one world: on one DoF of a joint, by the joint's number (N m, N).
struct ExtraEffort {
  int joint, dof;
  double value;
};

class Group {
 public:
  /// `scalar`: of the stepper.
  Group(Topology topology, const Tree& tree, int lanes, Variables variables, const PlanScalars& scalars = {});

  const Topology& topology() const { return topology_; }
  std::size_t key() const { return key_; }
  const Tree& tree() const { return tree_; }
  const TopologyPlan& plan() const { return plan_; }
  Variables variables() const { return variables_; }
  int worlds() const { return static_cast<int>(world_.size()); }
  int blocks() const { return (worlds() + lanes_ - 1) / lanes_; }
  /// The world in a slot; slots are filled from 0 without gaps.
  int world(int slot) const { return world_[at(slot)]; }

  /// Adds a world; returns its slot.
  int add(int world);
  /// Removes the world in that slot; the last one moves there. Returns the world that moved, −1: none.
  int remove(int slot);

  /// States are in variables().
  void set_state(int slot, const State& state);
  void get_state(int slot, State& state) const;
  /// The same for bare arrays; null when reading: not wanted.
  void set_values(int slot, double time, const double* q, const double* y, std::span<const Turns> turns = {}) noexcept;
  void get_values(int slot, double* q, double* y) const noexcept;
  /// State::turns() of a world.
  std::span<const Turns> turns(int slot) const { return {turns_.data() + turn(slot), tree_.loops().size()}; }
  double time(int slot) const { return time_[at(slot)]; }
  bool diverged(int slot) const { return diverged_[at(slot)] != 0; }
  void set_diverged(int slot, bool yes) { diverged_[at(slot)] = yes ? 1 : 0; }
  void set_efforts(int slot, std::span<const ExtraEffort> efforts);
  /// Sets the next step (s). The world does not change if it is 0, or if the world diverged.
  void set_step(int slot, double h) { h_[at(slot)] = diverged(slot) ? 0 : h; }
  Block block(int number);
  int lanes() const { return lanes_; }
  /// The group's number among all groups, given by the batch.
  int number() const { return number_; }
  void set_number(int number) { number_ = number; }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  // Index of number i of `count` per world.
  std::size_t place(int slot, int count, int i) const { return at((slot / lanes_ * count + i) * lanes_ + slot % lanes_); }
  std::size_t turn(int slot) const { return at(slot) * tree_.loops().size(); }
  void copy_slot(int from, int to);
  void resize(std::size_t slots);

  Topology topology_;
  std::size_t key_;
  Tree tree_;
  TopologyPlan plan_;
  int lanes_;
  Variables variables_;
  int number_ = 0;
  bool efforts_ = false;
  std::vector<int> world_;
  std::vector<double> q_, y_, effort_, time_, h_;
  std::vector<Turns> turns_;
  std::vector<unsigned char> diverged_;
};

}  // namespace momentree::batch
