#pragma once
// Many worlds of one model at once: in the lanes of the CPU's vectors, and on several threads. Each world may change its topology
// when it likes; worlds of one topology stand side by side, so that lanes stay full.
#include <memory>
#include <span>
#include <vector>

#include <momentree/batch/stepper.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

struct BatchOptions {
  /// float32: lanes are twice as many, the motion is as exact as float (seven digits). Changes are made in double either way.
  Precision precision = Precision::float64;
  int threads = 1;           ///< 0: as many as the machine has
  Isa widest = Isa::avx512;  ///< the widest instruction set to use, where the CPU and this build have it
};

/// Worlds move by steps of the classical Runge–Kutta method (rk4). A world's numbers are those of a scalar run to round-off, and
/// to the last bit the same whatever worlds stand beside it and however many threads there are; another width of lanes may round
/// otherwise, because multiply-adds are contracted.
///
/// Of forces, batches have all that act in joints: dampers, springs, constant efforts and those that change with time, position
/// control, friction, soft stops, prescribed motions; and efforts of each world's own. They have no forces on bodies, functions,
/// hard stops and strengths: the constructor and `edit` throw Error for a model that has. Energy is not booked.
///
/// A batch is used by one thread at a time. Its own threads call no functions of the user's.
class Batch {
 public:
  /// All worlds in the model's start state, at time 0. Throws Error: fewer than one world, fewer than 0 or more than 1024
  /// threads, a model with what batches do not have.
  Batch(const Model& model, int worlds, const BatchOptions& options = {});
  ~Batch();
  Batch(Batch&&) noexcept;
  Batch& operator=(Batch&&) noexcept;

  int worlds() const;
  Isa isa() const;
  int lanes() const;
  int threads() const;
  /// Topologies that worlds have at present.
  int groups() const;

  /// Every world makes a step of h seconds, which is finite and not negative.
  void step(double h) noexcept;
  /// Each world makes its own, by number: so that each gets to its own instants. 0: it stays as it is.
  void step(std::span<const double> h) noexcept;

  double time(int world) const;
  /// True for a world whose last step diverged: it stays where it was before, until its state is set.
  [[nodiscard]] bool ran_away(int world) const;
  /// The world's topology. Holds until the next edit.
  const Tree& tree(int world) const;
  /// A copy of its state, for tree(world): for forward_dynamics, energies, poses …
  [[nodiscard]] State state(int world) const;
  /// Coordinates, momenta and time; those of float32 worlds are rounded by the next step. The state is one for tree(world): from
  /// state() of it or of a world of the same topology, or made from that tree.
  void set_state(int world, const State& state);

  /// A further effort, finite, on one freedom of the joint that `body` carries (N m, N), from now on and until it is set again.
  /// Locked freedoms do not feel it. Goes with the joint, as long as that is of its kind.
  void set_effort(int world, BodyId body, int dof, double effort);

  /// A topology change of one world, or any other of topology/change.hpp; it then moves among the worlds that have the same.
  template <class Change>
  auto apply(int world, const Change& change) {
    Out& out = take_out(world);
    auto result = momentree::apply(change, out.tree, out.state, out.workspace);
    put_back(world);
    return result;
  }
  /// Any edit of one world: edit(tree, state, work), the work evaluated on the state. Several changes at one instant are one
  /// edit: forward_dynamics between them. Throws Error, and leaves the world as it was, for what batches do not have; so does
  /// whatever `edit` throws. It leaves the state one of the tree, and does nothing else with the batch but read it.
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
  // For as long as an edit of the user's has hold of the world that was taken out.
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
