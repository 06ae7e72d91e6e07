#pragma once
// A simulation: a running world with its state, event queue and energy ledger.
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/contact/impact.hpp>
#include <momentree/dynamics/forces/evaluation_context.hpp>
#include <momentree/dynamics/steps/rates_function.hpp>
#include <momentree/simulate/events/action.hpp>
#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/events/event.hpp>
#include <momentree/simulate/stepping/stepping_state.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

/// Time integration. `method`: "rk4", "midpoint" and "damped" have fixed steps; "dopri5" and "dop853" are adaptive.
struct Integration {
  std::string method = "rk4";
  /// What the state holds between events; by default what suits the method best (docs/howto/choose-a-method.md).
  std::optional<Variables> variables{};
  double step = 1e-3;              ///< s; the first step of adaptive methods
  double event_tolerance = 1e-10;  ///< s
  // For adaptive methods: see StepControl.
  double rtol = 1e-8;
  double atol = 1e-10;         ///< in the unit of each coordinate and velocity
  double max_step = HUGE_VAL;  ///< s
  /// How contacts that close at one instant share the impact.
  contact::Simultaneous simultaneous = contact::Simultaneous::together;
  /// Bodies that overlap at the start are pushed apart, with the least motion. Otherwise an overlap ends the run.
  bool resolve = false;

  /// The variables that a run uses, without a model those of open trees. Throws Error for a model with couplings that `method`
  /// can't integrate.
  Variables state_variables() const;
  /// Those of worlds with closed loops: velocities by default, if the method takes them.
  Variables loop_variables() const;
  Variables state_variables(const Model& model) const;
};

/// How a run ended. `refused`: an action was impossible; the world is as it was before that instant. `stalled`: hundreds of
/// thousands of steps or an endless sequence of events made next to no progress.
enum class [[nodiscard]] Status{ok, diverged, interrupted, refused, stalled};

/// How a run ended, and why: `if (const RunResult run = sim.run_until(3); !run) std::puts(run.reason.c_str());`
struct [[nodiscard]] RunResult {
  Status status = Status::ok;
  std::string reason{};  ///< for `diverged`, `refused` and `stalled`: the cause and a remedy; otherwise empty
  explicit operator bool() const { return status == Status::ok; }
  operator Status() const { return status; }  // NOLINT(google-explicit-constructor): `sim.run_until(3) != Status::ok`
};

/// Wall-clock times and counts as in the paper's Table 2: [0] before and [1] after the first topology change.
struct RunStatistics {
  double evaluation_seconds[2]{};  ///< an estimate: after the first 64 stages of steps, only every 17th is timed
  double topology_seconds = 0, total_seconds[2]{};
  long evaluations[2]{};
  long steps = 0, changes = 0;
  double worst_step_seconds = 0;
  /// The largest violation of the law of contact that a step through contacts left, as a velocity relative to the largest one of
  /// its island before the impulses; and when (s).
  double contact_residual = 0, contact_residual_at = 0;
};

/// Energy balance of the run (J). error = final + dissipated + lost_in_impacts + released − initial − work − projection.
struct EnergyBalance {
  double initial = 0, final = 0, dissipated = 0, work = 0, lost_in_impacts = 0, released = 0, error = 0;
  double projection = 0;       ///< energy that closing the loops after steps brought in
  double lost_in_steps = 0;    ///< the part of lost_in_impacts at contacts that were stepped through
  double largest_kinetic = 0;  ///< the largest kinetic energy at the beginning of a step or at an event
  double of_heights = 0;       ///< the energy that the bodies would get by falling their own size: the scale where nothing moves

  /// A warning with a suggested remedy if the error or the projection exceeds a thousandth of `largest_kinetic`, the latter with
  /// adaptive methods 100 relative tolerances; empty otherwise.
  /// Removing overlaps may add a twentieth where contacts are stepped through. Where hardly anything moves, errors below 1e-10 of
  /// `of_heights` are none, and below 1e-4 with steps through contacts.
  std::string advice(const Integration& integration) const;
};

/// What a run carries from step to step, besides the state of its world.
struct StepMemory {
  double next_step = 0;  ///< of an adaptive method: the step to try next (s)
  double work = 0;       ///< of an adaptive method: work done by forces so far, to which errors of the work are compared (J)
  SteppingState stepping{};
  std::vector<std::pair<std::string, DeeperStop>> deeper{};  ///< with the names of their joints
  friend bool operator==(const StepMemory&, const StepMemory&) = default;
};

/// A function that drives a joint, for drive_all().
struct JointDriver {
  std::string joint;
  JointFunction efforts;
};

struct QueueState;

/// State of a run at an instant.
struct SimulationSnapshot {
  WorldSnapshot world;
  std::vector<EventStatus> armed;  ///< by scheduled event, in the order of scheduling
  std::size_t events = 0;          ///< number of events that had happened
  EnergyBalance balance;           ///< with the energy dissipated and the work done by forces since the start
  double impulsive_work = 0;
  double proposal = 0;  ///< the next step of an adaptive method (s)
  SteppingState stepping{};
  std::shared_ptr<const QueueState> queue{};  ///< the same events, and strengths of joints and springs, with all that was noted
};

struct RunState;
struct Overlap;

/// The effect of all scheduled events on the topology, tried immediately in the present state of the world.
struct DryRun {
  struct Issue {
    std::size_t event = 0, action = 0;  ///< in the order of scheduling
    ActionResult result;                ///< skipped or refused
    std::string message;                ///< for a refusal
    double time = 0;                    ///< when the event is due (s)
  };
  std::vector<Issue> issues;
  /// Every joint that the world has now or would have later, with each kind that it would have.
  std::vector<std::pair<std::string, Kind>> joints;
  bool complete = true;  ///< false: not every event was tried, because there are too many or one needs an inertia that is missing
                         ///< now
};

/// Errors: set-up, scheduling and apply() throw Error for a user's mistake. A run does not throw: run_until(), step() and
/// try_apply() return a RunResult. Where exceptions are unwanted, check() and try_apply() report the same errors without
/// throwing.
///
/// Callbacks, and what they may do with the simulation that calls them:
///
/// - observe(), sample(), watch(): may read everything, take a snapshot(), make a branch(), and schedule events with at(),
/// when(), after()
///   and every(). Any other change to the simulation terminates the program: return false instead, and make the change after
///   run_until().
/// - measured(), use_generated(): may read the world or the tree that is passed to them.
/// - drive(), force(): may read only the EvaluationContext that is passed to them; they must not throw.
///
/// Exceptions that other callbacks throw propagate out of run_until(); the simulation is then at the last instant that it
/// reached, and can be continued.
///
/// A simulation may be used by one thread at a time. Several simulations, even of one Model, may run in several threads;
/// functions that they share, as branches do, are then called from each of these threads.
class Simulation {
 public:
  struct Impl;

  /// Compiles the model. Throws Error for an unknown method, a step or tolerance that is not positive, or a singular joint-space
  /// inertia.
  explicit Simulation(const Model& model, const Integration& integration = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Schedules actions at `time` (s): `at(1.8).then(break_joint("chain/41"))`. Actions at the same instant are ordered as
  /// described in simulate/instant.hpp. Throws Error for a time that is past or not finite, and for an unknown name: one that
  /// belongs to no body, to no joint of the model or of the present world, and to no joint that an event scheduled earlier makes.
  /// A handle stays valid for as long as the simulation exists, even if the simulation is moved.
  class [[nodiscard]] Scheduled {
   public:
    /// Throws Error if the event has happened and will not happen again.
    Scheduled& then(Action action);
    /// `by_user`: a joint that the event makes then has that name.
    Scheduled& named(std::string name, bool by_user = true);
    /// Of events that are due at one instant, the one with the lowest rank comes first; without ranks, the one scheduled first.
    Scheduled& ranked(std::size_t rank);

    Scheduled(std::weak_ptr<Impl> impl, std::size_t event) : impl_(std::move(impl)), event_(event) {}

   private:
    std::shared_ptr<Impl> impl() const;
    std::weak_ptr<Impl> impl_;
    std::size_t event_;
  };
  Scheduled at(double time);
  /// Schedules actions for when a condition is met:
  /// `when(reaction_force("crane/hook").exceeds(4e3)).then(break_joint("crane/hook"))`. Throws Error for an unknown name, for a
  /// threshold that is not finite or can never be crossed, and for a quantity that needs a joint with one DoF if the joint has
  /// another number of DoFs, unless a scheduled event changes that joint.
  Scheduled when(Condition condition);
  /// Schedules actions `delay` seconds after the event with that name, each time that it happens; a joint with a strength has an
  /// event "strength of <joint>".
  Scheduled after(std::string event, double delay = 0);
  /// Schedules actions at `from` (s) and every `period` seconds from then on; instants before the present time don't happen.
  /// Throws Error for a period that is not positive or is shorter than the clock can resolve.
  Scheduled every(double period, double from = 0);

  /// Carries out actions immediately as an event with this name (empty: named by its place), and returns the event. Throws Error
  /// if one of them is impossible; nothing has then happened.
  Event apply(std::span<const Action> actions, std::string name = {});
  Event apply(const Action& action, std::string name = {}) { return apply(std::span(&action, 1), std::move(name)); }
  /// Like apply(), but returns Status::refused with the reason instead of throwing: for an unknown name, too.
  RunResult try_apply(std::span<const Action> actions, std::string name = {});
  RunResult try_apply(const Action& action, std::string name = {}) { return try_apply(std::span(&action, 1), std::move(name)); }
  /// The error that then() and apply() would throw for an unknown name in an action; nothing if all names are known.
  [[nodiscard]] std::optional<Error> check(const Action& action) const;
  /// The error that when() would throw because closed loops do not determine the reaction in a condition; nothing if they do.
  [[nodiscard]] std::optional<Error> check(const Condition& condition) const;

  /// Changes gravity from now on (m/s², world axes). The resulting change of potential energy counts as work. The history that
  /// keep_history() kept is discarded; snapshots taken before restore the former gravity. Throws Error for values that are not
  /// finite.
  void set_gravity(Vec3 gravity);

  /// Steps to `time` (s), landing exactly on every scheduled event and on `time`; events at `time` happen. Does nothing if `time`
  /// is past. On divergence the state is the last good one, and the reason says which joint diverged, when, and how to prevent
  /// it. An infinite `time` requests a run that an observer or a watcher ends. Throws Error for NaN, and for an infinite time if
  /// nothing can end the run.
  RunResult run_until(double time);
  /// Makes one step of `dt` seconds, for user-written loops (events within it happen at their instants). Throws Error for a step
  /// that is negative, not a number, or shorter than the clock can resolve; for infinity see run_until().
  RunResult step(double dt);

  /// Stages of steps run code that was generated for the topology instead of the kernels, if the provider has such code (see
  /// KernelCache) for the variables of the state; the provider is called before the first step after each change. Results agree
  /// to round-off, and depend on which stages ran which code. Branches keep the provider; an empty one removes it.
  void use_generated(RatesProvider provider);

  /// Sets the observer. It is called when run_until first starts, at every multiple of `every` seconds (after each step if 0),
  /// and when run_until ends; never twice at the same time, and after the events at that time. Steps land on these instants. If
  /// it returns false, run_until returns Status::interrupted. An event that it schedules for the present time happens next. There
  /// is one observer: a new one replaces it, an empty one removes it. Throws Error for a period that is negative, not finite or
  /// shorter than the clock can resolve.
  void observe(double every, std::function<bool(const World&)> observer);

  /// Sets the sampler, for extremes and other measures of a run. It is called with the state at the end of every step, both
  /// before and after the events of that instant; unlike an observer it does not affect the steps. If it returns false, run_until
  /// returns Status::interrupted: before the events if it was called before them, and these are then still due. There is only
  /// one.
  void sample(std::function<bool(const World&)> sampler);

  /// Sets the watcher. It is called with the time (s) after each step, independently of the observer's period: for a progress
  /// bar, or to interrupt the run by returning false. Like the observer, there is only one.
  void watch(std::function<bool(double)> watcher);

  /// Drives a joint by a function from now on: it returns the force or torque (N, N m) along the joint's single DoF, in its
  /// declared direction, in addition to its parameters. It is called at every stage of every step, must not throw, and may depend
  /// only on the evaluation context. An empty function removes it. It belongs to the joint: topology changes, snapshots and
  /// branches keep it until the joint breaks or is changed into another. Throws Error for an unknown name, a weld, a joint with
  /// several DoFs, or one whose motion is prescribed.
  void drive(std::string_view joint, std::function<double(const EvaluationContext&)> effort);
  /// The same for any number of DoFs: the function fills in a list (N, N m), in the order of v, which is initially zero.
  void drive_all(std::string_view joint, JointFunction efforts);
  /// The same for many joints at the cost of one evaluation; on an error all joints keep their former functions.
  void drive_all(std::vector<JointDriver> drivers);
  /// Applies a wrench to a body by a function from now on, in addition to the model's forces: force (N) and torque (N m) about
  /// the origin of the body's frame, in world axes. Like a drive, it is called at every stage of every step. Its work is
  /// accounted for. It belongs to the body, whatever the body is joined to; snapshots and branches keep it. An empty function
  /// removes it; another one replaces it. Throws Error for an unknown name and for a body that was removed.
  void force(std::string_view body, BodyFunction wrench);

  /// Restarts from a state document (World::restore); energy ledger and events are reset. `check` may throw if it does not
  /// accept the restored world. If an error is thrown, nothing has changed.
  void restore(double time, const Forest& forest, std::span<const JointStart> joints,
               const std::function<void(const World&)>& check = {});

  /// Restarts at another state of the present topology: time (s, not negative), coordinates q (nq numbers: rad, m, unit
  /// quaternions) and momenta p (nv numbers, see World::momenta_of), packed in the order of joint numbers. Energy ledger, events
  /// and history are reset; functions stay. Scheduled events stay, too: those that are past by then will not happen, and if the
  /// clock is set back, those that are no longer past can happen again.
  ///
  /// Joints with a prescribed motion follow it at that time, whatever q and p say, and locked DoFs have no momentum. A DoF that
  /// rests on a stop is released unless its coordinate is the present one and its momentum 0. Quaternions are normalised. Throws
  /// Error, with nothing changed, for lists of other lengths, numbers that are not finite, a quaternion that differs from unit
  /// length by more than 1e-6, a coordinate beyond a hard stop, and a negative time.
  void set_state(double time, std::span<const double> q, std::span<const double> p) { set_state(time, q, p, Variables::momenta); }
  /// The same from momenta or from velocities.
  void set_state(double time, std::span<const double> q, std::span<const double> y, Variables given);

  /// Moves the present state to these coordinates and momenta (see set_state()), and the run goes on: events and history stay,
  /// and the energy that this adds counts as work.
  void adjust(std::span<const double> q, std::span<const double> p) { adjust(q, p, Variables::momenta); }
  /// The same to momenta or to velocities.
  void adjust(std::span<const double> q, std::span<const double> y, Variables given);

  /// Adds a body to any body of the world or to the ground, with the coordinates and velocities of its spec; the velocities of
  /// other bodies do not change, so that a joint at rest takes no energy. The body and its joint get the next number. Throws
  /// Error as Model::add does, and for a joint that would move no mass.
  ///
  /// `collision`: what it touches others with, by the contact rules of the model. What it touches it hits at this instant. A
  /// body that overlaps others is an Error that names the pair and the depth, or all that overlap are pushed apart
  /// (Integration::resolve), whose energy counts as work. Throws Error for a method that does not support contact.
  BodyId add(BodySpec spec, std::vector<contact::Solid> collision = {});
  /// Removes a body and all bodies outboard of it from the world; the joint that carries it breaks first. Their names and numbers
  /// are not used again. Actions scheduled for them are skipped or refused.
  void remove(BodyId body);

  /// Carries out all scheduled events in their order in the present state, without time integration, and reverts everything:
  /// reports which actions will have nothing to do or are impossible, and which joints will exist. Events that depend on a
  /// condition have no known order: they are tried in the order of scheduling.
  [[nodiscard]] DryRun dry_run();

  /// The complete state of the run at this instant; restoring it is exact to the last bit, across any number of changes.
  [[nodiscard]] SimulationSnapshot snapshot() const;
  /// Events scheduled after the snapshot stay scheduled unless their time is past. Observers stay. The snapshot must be of a
  /// simulation of the same model.
  void restore(const SimulationSnapshot& snapshot);
  /// From now on, keeps a snapshot from before every instant at which something happens; at most the last `most` of them.
  void keep_history(std::size_t most = std::numeric_limits<std::size_t>::max());
  /// Returns to just before the `number`-th of events() happened. Throws Error if the history was not kept. The actions scheduled
  /// for that instant do not happen again unless `again` is true: the run then takes another branch.
  void undo(std::size_t number, bool again = false);
  /// True if the history reaches back that far.
  [[nodiscard]] bool can_undo(std::size_t number) const;
  /// An independent run from here: world, event queue and energy ledger, without observers and history.
  [[nodiscard]] Simulation branch() const;

  /// The run between two steps, to be continued later or in another process (simulate/run_state.hpp): outside of a run, or in the
  /// callback of observe() or watch(). From that of observe(), a new run begins.
  [[nodiscard]] RunState run_state() const;
  /// Continues a run: the next run_until() goes on as the run itself would have, to the last bit. Call it on a simulation of the
  /// same model at the start of its run, after everything has been scheduled and set that the run had: events, drives, forces,
  /// and the observer with its period. History is not part of a RunState.
  void continue_from(const RunState& state);

  double time() const;
  const Integration& integration() const;
  const World& world() const;
  const std::vector<Event>& events() const;
  /// Removes events before `time` (s) from events(), so that they take no memory in an endless run. Those of the last 0.1 s stay,
  /// and the last event, because the run may need them. The history that keep_history() kept is discarded, and snapshots taken
  /// before do not restore the events.
  void forget_events(double time);
  /// Scheduled events that have not happened so far, in the order of scheduling.
  std::vector<MissedEvent> missed() const;
  const RunStatistics& statistics() const;
  EnergyBalance energy() const;
  /// What to know before using the results, with remedies: advice() on the energy balance, and bodies that passed through each
  /// other within a step.
  std::vector<std::string> warnings() const;
  /// The result of the last run_until(), step() or try_apply().
  const RunResult& result() const;

  /// For code of the library that steps or restores simulations (simulate/simulation_impl.hpp). `changing`: stops the program
  /// inside of callbacks.
  friend Impl& implementation(const Simulation& simulation, bool changing) {
    return changing ? simulation.changing() : simulation.impl();
  }

 private:
  Impl& impl() const;
  Impl& changing() const;
  Impl& scheduling() const;
  Impl& steady() const;
  std::shared_ptr<Impl> impl_;  // shared only during a call: handles merely check whether it still exists
};

// What programs need that prepare simulations, restore them or step them again and again.

/// Declares names of joints that events scheduled later will make: conditions and actions may then refer to them.
void expect_joints(Simulation& simulation, const std::vector<std::string>& names);

/// Call it between two runs when other numbers that functions use have changed. `preview`: accelerations and contacts are read
/// before the next run; otherwise they may still be those of the former contacts.
void functions_changed(Simulation& simulation, bool preview = true);

/// Restarts at a world of the same model, from World::snapshot() of this or another simulation: as set_state() does, also across
/// changes of topology. Nothing of the run before has an effect on what follows. Functions are those of the snapshot.
void restart(Simulation& simulation, const WorldSnapshot& start);

/// The bodies that overlap most at present, or the cable that is most too short; nothing if there are none. More than 1e-8 of the
/// coordinates is an overlap. See simulate/overlap.hpp.
[[nodiscard]] std::optional<Overlap> overlap(const Simulation& simulation);

StepMemory step_memory(const Simulation& simulation);
/// Continues as another run would have: with the state of its adaptive method (a next step of 0: keep the present one), that of
/// its contacts, if the state was restored with them, and that of its events, in the order of scheduling (the list may be shorter
/// than the list of events scheduled here).
void resume(Simulation& simulation, std::span<const EventStatus> armed, const StepMemory& memory = {});

}  // namespace momentree
