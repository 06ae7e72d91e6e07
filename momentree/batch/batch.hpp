#pragma once
// Many worlds of one model at once: in the CPU's SIMD lanes and on several threads. Each world may change its topology at any
// time; worlds with the same topology are packed together, so that lanes stay full.
#include <memory>
#include <span>
#include <vector>

#include <momentree/batch/stepper.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

struct BatchOptions {
  /// float32 doubles the number of lanes; the motion is as accurate as float (seven digits). Topology changes are made in double
  /// in either case.
  Precision precision = Precision::float64;
  int threads = 1;           ///< 0: as many as the machine has
  Isa widest = Isa::avx512;  ///< the widest instruction set to use, if the CPU and this build support it
};

/// Worlds are integrated by the classical Runge–Kutta method (rk4). The results of a world equal those of a scalar run to
/// round-off; they are bit for bit the same whatever other worlds are in the batch and for any number of threads. Another lane
/// width may round differently, because multiply-adds are contracted.
///
/// Batches support all forces that act in joints: dampers, springs, constant and time-dependent efforts, position control,
/// friction, soft stops, prescribed motions, and extra efforts per world. They do not support forces on bodies, functions, hard
/// stops and strengths: the constructor and `edit` throw Error for a model that has any. There is no energy ledger.
///
/// A batch is used by one thread at a time. Its own threads call no user functions.
class Batch {
 public:
  /// All worlds in the model's start state, at time 0. Throws Error: fewer than one world, fewer than 0 or more than 1024
  /// threads, a model with unsupported features.
  Batch(const Model& model, int worlds, const BatchOptions& options = {});
  ~Batch();
  Batch(Batch&&) noexcept;
  Batch& operator=(Batch&&) noexcept;

  int worlds() const;
  Isa isa() const;
  int lanes() const;
  int threads() const;
  /// Number of different topologies at present.
  int groups() const;

  /// Steps every world by h seconds, finite and not negative.
  void step(double h) noexcept;
  /// Steps each world by its own h (s, one entry per world), so that each can reach its own instants. 0: the world does not
  /// change.
  void step(std::span<const double> h) noexcept;

  /// Time of a world (s).
  double time(int world) const;
  /// True for a world whose last step diverged: it keeps its state from before that step until its state is set.
  [[nodiscard]] bool ran_away(int world) const;
  /// The world's topology. Valid until the next edit.
  const Tree& tree(int world) const;
  /// A copy of the world's state, for tree(world): for forward_dynamics, energies, poses …
  [[nodiscard]] State state(int world) const;
  /// Sets coordinates, momenta and time; the next step of a float32 world rounds them. The state must belong to tree(world): from
  /// state() of this world or of one with the same topology, or made from that tree.
  void set_state(int world, const State& state);

  /// Sets an extra effort, finite, on one DoF of a joint (N m, N), until it is set again. It has no effect
  /// on a locked DoF. It stays with the joint as long as the joint's kind does not change.
  void set_effort(int world, JointId joint, int dof, double effort);

  /// Applies one change of topology/change.hpp to one world, which then joins the worlds with the same topology.
  template <class Change>
  auto apply(int world, const Change& change) {
    Out& out = take_out(world);
    auto result = momentree::apply(change, out.tree, out.state, out.workspace);
    put_back(world);
    return result;
  }
  /// Any edit of one world: edit(tree, state, workspace), with the workspace evaluated on the state. Several changes at one
  /// instant are one edit, with forward_dynamics in between. Throws Error and leaves the world unchanged if the result has
  /// unsupported features or if `edit` throws. The edit must leave the state valid for the tree, and may otherwise only read the
  /// batch.
  template <class Edit>
  void edit(int world, Edit&& edit) {
    Out& out = take_out(world);
    const Editing editing(*this);
    edit(out.tree, out.state, out.workspace);
    put_back(world);
  }

 private:
  struct Impl;
  struct Out {
    Tree tree;
    State state;
    Workspace<double> workspace;
  };
  // Marks the time during which a user's edit has access to the world taken out.
  class Editing {
   public:
    explicit Editing(Batch& batch);
    ~Editing();
    Editing(const Editing&) = delete;
    Editing& operator=(const Editing&) = delete;

   private:
    Impl& impl_;
  };
  Impl& impl() const;
  Impl& changing() const;
  Out& take_out(int world);
  void put_back(int world);
  std::unique_ptr<Impl> impl_;
};

}  // namespace momentree
