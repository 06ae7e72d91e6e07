#pragma once
// Many worlds of one model at once: in the CPU's SIMD lanes and on several threads. Each world may change its topology at any
// time; worlds with the same topology are packed together, so that lanes stay full.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <momentree/batch/stepper.hpp>
#include <momentree/dynamics/motion.hpp>
#include <momentree/simulate/events/action.hpp>
#include <momentree/simulate/events/event.hpp>
#include <momentree/simulate/world/world.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

struct BatchOptions {
  /// float32 doubles the number of lanes; the motion is as accurate as float (seven digits). Topology changes are made in double
  /// in either case.
  Precision precision = Precision::float64;
  /// What states hold between changes, as for single worlds: see docs/howto/choose-a-method.md. Not given: velocities for models
  /// with closed loops or couplings, and for worlds while they have loops; otherwise momenta.
  std::optional<Variables> variables{};
  int threads = 1;           ///< 0: as many as the machine has
  Isa widest = Isa::avx512;  ///< the widest instruction set to use, if the CPU and this build support it
  /// How worlds with contact are integrated: "stepping" steps through contacts; "rk4", "dopri5" and "dop853" locate every instant
  /// at which they change. See docs/contact.md.
  std::string contact_method = "stepping";
  /// Of worlds that are stepped one by one: their longest step (s), of adaptive methods the first. A longer step of the batch is
  /// divided. Without effect on worlds in lanes, which take each step of the batch at once.
  double step = 1e-3;
};

/// Worlds are stepped in lanes, by the classical Runge–Kutta method (rk4). In double precision a world has the bits of a
/// simulation with the same steps, whatever other worlds are in the batch and for any number of threads, except where no machine
/// code is made for the lanes (baseline on x86-64): there it equals the simulation to round-off.
///
/// Worlds in lanes have all forces that act in joints: dampers, springs, constant and time-dependent efforts, position control,
/// friction, soft stops, prescribed motions, and extra efforts per world. If the model has contact, cables, forces on bodies,
/// springs between points, hard stops or strengths, its worlds are stepped one by one: each by a Simulation of its own, on the
/// batch's threads, with the bits of a Simulation with the same calls of step(). With contact and cables they hold velocities
/// and are integrated by BatchOptions::contact_method, otherwise by rk4. An edit or action that gives worlds in lanes such a
/// feature is an Error, and so are functions in any batch. There is no energy ledger.
///
/// Worlds with closed loops or exact couplings are stepped in double, in lanes in velocities, and one by one in momenta: then
/// exactly as by a Simulation with the method rk4. Their start values, and states that are set, are brought to the nearest ones
/// that close the loops.
///
/// Worlds are numbered from 0. Functions for several worlds take their numbers in any order, and arrays with one row per number,
/// row-major. In those with coordinates, momenta or velocities the worlds must all be in one group, that is, have the same
/// topology; rows then have nq or nv numbers, packed in the order of joint numbers (rad, m, unit quaternions; velocities, momenta
/// and efforts as in docs/models.md).
///
/// A batch is used by one thread at a time. Its own threads call no user functions.
class Batch {
 public:
  /// All worlds in the model's start state, at time 0. Throws Error: fewer than one world, fewer than 0 or more than 1024
  /// threads, a model with functions, bodies that overlap, a method that is not one of contact, a step that is not positive.
  Batch(const Model& model, int worlds, const BatchOptions& options = {});
  ~Batch();
  Batch(Batch&&) noexcept;
  Batch& operator=(Batch&&) noexcept;

  int worlds() const;
  Isa isa() const;
  /// What the states of worlds without closed loops hold, and what that of a world holds.
  Variables variables() const;
  Variables variables(int world) const;
  /// Worlds that are stepped at once by each thread: 1 if they are stepped one by one.
  int lanes() const;
  int threads() const;
  /// Number of different topologies at present.
  int groups() const;
  /// The group of a world, from 0 to groups() − 1, in the order of their first worlds. It may change whenever a topology does.
  int group(int world) const;
  /// Numbers of coordinates and of DoFs of a world.
  int nq(int world) const;
  int nv(int world) const;

  /// Steps every world by h seconds, finite and not negative.
  void step(double h) noexcept;
  /// Steps each world by its own h (s, one entry per world), so that each can reach its own instants. 0: the world does not
  /// change.
  void step(std::span<const double> h) noexcept;

  /// Time of a world (s).
  double time(int world) const;
  /// True for a world whose last step diverged, ended where its loops cannot be closed, or was impossible, such as from a state
  /// in which bodies overlap by more than 1 mm: it keeps its state from before that step until its state is set.
  [[nodiscard]] bool diverged(int world) const;
  /// Why, and what to do about it; empty if it did not.
  [[nodiscard]] std::string message(int world) const;
  /// The world's topology, without closed contacts; joints that rest on stops are free in it. Valid until the next edit, and with
  /// worlds that are stepped one by one until the next step.
  const Tree& tree(int world) const;
  /// A copy of the world's state, in variables(world), for tree(world): for forward_dynamics, energies, poses …
  [[nodiscard]] State state(int world) const;
  /// Sets coordinates, momenta or velocities, and time; the next step of a float32 world rounds them. The state must belong to
  /// tree(world): from state() of this world or of one with the same topology, or made from that tree. One in the other variables
  /// is converted. Throws Error if its loops cannot be closed.
  void set_state(int world, const State& state);

  /// Returns worlds to the model's start state, time and topology, without extra efforts.
  void reset(std::span<const int> worlds);

  /// Sets an extra effort, finite, on one DoF of a joint (N m, N), until it is set again. It has no effect
  /// on a locked DoF. It stays with the joint as long as the joint's kind does not change. Throws Error for a joint that closes a
  /// loop: its efforts are parameters.
  void set_effort(int world, JointId joint, int dof, double effort);

  /// Writes a row per world: time (s), coordinates, momenta and velocities. Null: not wanted. Those that are not variables(world)
  /// cost an evaluation: of velocities in the precision of the batch, of momenta in double. Throws Error for worlds of several
  /// groups.
  void read(std::span<const int> worlds, double* time, double* q, double* p, double* v) const;
  /// The same for a joint that closes a loop in all of these worlds: rows of its coordinates and of the velocities of its DoFs,
  /// which follow from the motion of its bodies. Throws Error for worlds of several groups.
  void read_loop(std::span<const int> worlds, JointId joint, double* q, double* v) const;
  /// Sets time, coordinates and y, momenta or velocities, from a row per world, as set_state() does; null: as they are, which for
  /// y means variables(world). Quaternions are normalised; joints with a prescribed motion follow it, and locked DoFs have no
  /// momentum or velocity. Throws Error, with nothing changed, for worlds of several groups, numbers that are not finite, a
  /// negative time, a quaternion that differs from unit length by more than 1e-6, and loops that cannot be closed.
  void write(std::span<const int> worlds, const double* time, const double* q, const double* y, Variables given);
  /// The same with momenta.
  void write(std::span<const int> worlds, const double* time, const double* q, const double* p) {
    write(worlds, time, q, p, Variables::momenta);
  }
  /// The momenta p of velocities v at coordinates q, in the worlds' topology, a row per world. DoFs with a prescribed motion have
  /// its position and rate at `time` (s, one per world; null: the worlds' present times), and locked DoFs are at rest. Throws
  /// Error as write() does.
  void momenta_of(std::span<const int> worlds, const double* q, const double* v, double* p, const double* time = nullptr) const;
  /// Sets the extra efforts of all DoFs, a row per world, as set_effort() does. Throws Error, with nothing changed, for worlds of
  /// several groups and numbers that are not finite.
  void set_efforts(std::span<const int> worlds, const double* efforts);
  /// Writes 13 numbers per world, world axes: position of the origin of a body's frame (m), its quaternion (w, x, y, z), velocity
  /// of its origin (m/s), angular velocity (rad/s). The worlds may have different topologies; where the body was removed, the
  /// numbers are NaN. Throws Error for a body that none of the worlds ever had.
  void motions(std::span<const int> worlds, BodyId body, double* thirteen) const;

  /// The points at which bodies touch, as World::contacts(): after steps by "stepping" with mean forces of the last one; after
  /// the state or topology was set, those with which the next step begins. Empty in lanes.
  [[nodiscard]] std::vector<ContactPoint> contacts(int world) const;
  /// Writes 3 numbers per world: the sum of the forces of contacts() on a body, or on the ground (N, world axes). Zero if it
  /// touches nothing; NaN where it was removed. The worlds may have different topologies. Cables are no contacts.
  void contact_forces(std::span<const int> worlds, BodyId body, double* forces) const;
  /// Events of a world that is stepped one by one, since its last step began: of contacts, stops and strengths, and of apply().
  /// Valid until it is next stepped or changed. Empty in lanes.
  [[nodiscard]] std::span<const Event> events(int world) const;

  /// Carries out actions in one world immediately as one event, as Simulation::apply does: with the same names, checks, errors
  /// and certificate. `name`: of the event; empty: #1, #2 … by the number of such events in that world. Joints and mechanisms
  /// keep the names that earlier actions gave them; after changes by other functions of this class, parts that broke off are
  /// named as actions would. Throws Error, with the world unchanged, if an action is impossible or leads to features that batches
  /// do not support, and for a world to which bodies were added. In lanes it costs a copy of the world into a Simulation and
  /// back.
  Event apply(int world, std::span<const Action> actions, std::string name = {});
  Event apply(int world, const Action& action, std::string name = {}) {
    return apply(world, std::span(&action, 1), std::move(name));
  }
  /// The present name of a joint of a world, as actions know it; empty if the joint was removed.
  std::string joint_name(int world, JointId joint) const;
  /// The joint that has that name in a world at present, if there is one.
  std::optional<JointId> find_joint(int world, const std::string& name) const;

  /// Applies one change of topology/change.hpp to one world, which then joins the worlds with the same topology.
  template <class Change>
  requires requires(const Change& change, Tree& tree, State& state, Workspace<double>& workspace) {
    momentree::apply(change, tree, state, workspace);
  }
  auto apply(int world, const Change& change) {
    Out& out = take_out(world);
    auto result = momentree::apply(change, out.tree, out.state, out.workspace);
    put_back(world);
    return result;
  }
  /// Any edit of one world: edit(tree, state, workspace), with the workspace evaluated on the state. Several changes at one
  /// instant are one edit, with forward_dynamics in between. Closed contacts have no part in it: the next step finds them anew.
  /// Throws Error and leaves the world unchanged if the result has
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
