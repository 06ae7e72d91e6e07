#pragma once
// A world that runs: model, state, scheduled events, books.
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/dynamics/evaluation_context.hpp>
#include <momentree/dynamics/rates_function.hpp>
#include <momentree/simulate/action.hpp>
#include <momentree/simulate/condition.hpp>
#include <momentree/simulate/event.hpp>
#include <momentree/simulate/event_queue.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

/// How to step. `method`: "rk4", "midpoint", "damped", of fixed steps; "dopri5", "dop853", which choose theirs.
struct Integration {
  std::string method = "rk4";
  double step = 1e-3;              ///< s; for adaptive methods the first one
  double event_tolerance = 1e-10;  ///< s
  // Adaptive methods: see StepControl.
  double rtol = 1e-8;
  double atol = 1e-10;         ///< in the unit of each coordinate and velocity
  double max_step = HUGE_VAL;  ///< s
};

/// `refused`: an action was impossible; the world is as it was before its instant, and message() says which and why.
/// `stalled`: hundreds of thousands of steps, or events without end, took the run next to nowhere; message() says what to do.
enum class [[nodiscard]] Status{ok, diverged, interrupted, refused, stalled};

/// Wall-clock and counts as in the paper's Table 2, [0] before and [1] after the first topology change.
struct RunStatistics {
  double evaluation_seconds[2]{}, topology_seconds = 0, total_seconds[2]{};
  long evaluations[2]{};
  long steps = 0, changes = 0;
  double worst_step_seconds = 0;
};

/// Energy balance of the run (J). error = final + dissipated + lost_in_impacts + released − initial − work.
struct EnergyBalance {
  double initial = 0, final = 0, dissipated = 0, work = 0, lost_in_impacts = 0, released = 0, error = 0;
  double largest_kinetic = 0;  ///< the largest kinetic energy at the beginning of a step, or at an event

  /// What to say where the error is more than a thousandth of that, and how to mend it; empty otherwise.
  std::string advice(const Integration& integration) const;
};

/// All that an adaptive method remembers from step to step.
struct StepMemory {
  double next_step = 0;  ///< the step to try next (s)
  double work = 0;       ///< what forces have done so far, beside which errors of their work are judged (J)
  friend bool operator==(const StepMemory&, const StepMemory&) = default;
};

/// A function that drives a joint, as drive_all() takes it.
struct JointDriver {
  std::string joint;
  JointFunction efforts;
};

/// A run at an instant.
struct SimulationSnapshot {
  WorldSnapshot world;
  std::vector<EventQueue::Armed> armed;  ///< by scheduled event, in the order of scheduling
  std::size_t events = 0;                ///< how many had happened
  EnergyBalance balance;                 ///< with what was dissipated and done by forces since the start
  double impulsive_work = 0;
  double proposal = 0;  ///< the next step of an adaptive method (s)
};

/// What all that is scheduled would do to the topology, tried at once where the world stands now.
struct DryRun {
  struct Issue {
    std::size_t event = 0, action = 0;  ///< in the order of scheduling
    ActionResult result;                ///< skipped or refused
    std::string message;                ///< of a refusal
  };
  std::vector<Issue> issues;
  /// Every joint that the world has now or would come to have, with each kind that it would be of.
  std::vector<std::pair<std::string, Kind>> joints;
  bool complete = true;  ///< false: not every event was tried; there are too many, or one needs an inertia that is missing now
};

/// Callbacks, and what they may do with the simulation that calls them:
///
/// - observe(), watch(): read everything, snapshot(), branch(), and schedule with at(), when(), after() and every(). All else
///   that changes the simulation stops the program: return false, and do it after run_until().
/// - measured(), use_generated(): read the world, or the tree, that they are given.
/// - drive(), force(): read the Moment that they are given, nothing else; they must not throw.
///
/// What other callbacks throw leaves run_until(); the simulation then stands at the last instant that it reached, and can go on.
///
/// A simulation is used by one thread at a time. Several of them may run in several threads, also of one Model; functions that
/// they share, as branches do, are then called from each of these threads.
class Simulation {
  struct Impl;

 public:
  /// Compiles the model. Throws Error: an unknown method, a step or tolerance that is not positive, a singular joint-space mass.
  explicit Simulation(const Model& model, const Integration& integration = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Schedules actions for an instant not yet past: `at(1.8).then(break_joint("chain/41"))`. What happens at one instant happens
  /// in the order that simulate/instant.hpp says. Throws Error for a time that is past or not finite, and for a name that is
  /// none: of a body, of a joint of the model or of the world as it is, or of one that an event scheduled before makes.
  /// A handle may be kept as long as the simulation is there, wherever that is moved.
  class [[nodiscard]] Scheduled {
   public:
    /// Throws Error where the event has happened and will not happen again.
    Scheduled& then(Action action);
    /// `by_user`: a joint that it makes then has that name.
    Scheduled& named(std::string name, bool by_user = true);
    /// Of events that are due at one instant the one of the lowest rank comes first; without it, the first that was scheduled.
    Scheduled& ranked(std::size_t rank);

   private:
    friend class Simulation;
    Scheduled(std::weak_ptr<Impl> impl, std::size_t event) : impl_(std::move(impl)), event_(event) {}
    std::shared_ptr<Impl> impl() const;
    std::weak_ptr<Impl> impl_;
    std::size_t event_;
  };
  Scheduled at(double time);
  /// The same when a condition comes true: `when(reaction_force("crane/hook").exceeds(4e3)).then(break_joint("crane/hook"))`.
  /// Throws Error for an unknown name, a threshold that is not finite or can never be passed, a quantity of joints with one
  /// freedom where the joint has another number of them, unless an event that is scheduled changes it.
  Scheduled when(Condition condition);
  /// `delay` seconds after the event of that name, each time that it happens; "strength of <joint>" is one for a joint with a
  /// strength.
  Scheduled after(std::string event, double delay = 0);
  /// At `from` and every `period` seconds from then on. Throws Error for a period that is not positive or shorter than the clock
  /// can resolve.
  Scheduled every(double period, double from = 0);

  /// Joints of these names will come to be, made by events that are scheduled later: conditions and actions may name them now.
  void expect_joints(const std::vector<std::string>& names);

  /// Does actions now, as an event of this name (empty: by its place), and returns the event. Throws Error where one is
  /// impossible: nothing then happened.
  Event apply(std::span<const Action> actions, std::string name = {});
  Event apply(const Action& action, std::string name = {}) { return apply(std::span(&action, 1), std::move(name)); }
  /// The same without throwing: Status::refused where one is impossible, and message() says why.
  Status attempt(std::span<const Action> actions, std::string name = {});
  Status attempt(const Action& action, std::string name = {}) { return attempt(std::span(&action, 1), std::move(name)); }
  /// What is wrong with the names that an action holds, as then() and apply() would throw it; nothing where all are known.
  [[nodiscard]] std::optional<Error> unknown_name(const Action& action) const;

  /// Another gravity from now on (m/s², world axes). What it gives to potential energy, or takes from it, counts as work. What
  /// keep_history() kept is forgotten; snapshots taken before do not bring the former gravity back. Throws Error for numbers that
  /// are not finite.
  void set_gravity(Vec3 gravity);

  /// Steps to `time`, exactly onto every scheduled event and `time`; events at `time` happen. Nothing moves where `time` is past.
  /// On divergence the state is the last good one and `message()` says which joint, when, and what to do. An infinite `time` asks
  /// for a run that an observer or a watcher ends. Throws Error for a time that is not a number, and for one that is infinite
  /// where nothing can end the run.
  Status run_until(double time);
  /// One step of `dt` seconds for a loop of your own (events inside it happen at their instants). Throws Error for a step that
  /// is negative, not a number, or shorter than the clock can resolve; for an infinite one see run_until().
  Status step(double dt);

  /// Stages of steps run code that was generated for the topology in the place of the kernels, where the provider has some (see
  /// KernelCache); it is asked before the first step after each change. Results agree to round-off, and depend on which stages
  /// ran which code. Branches keep it; an empty one ends it.
  void use_generated(RatesProvider provider);

  /// Called when run_until first starts, then at every multiple of `every` seconds (after each step if 0), and when run_until
  /// ends; never twice at one time; where events happen at that time, after them. Steps land on these instants. Return false to
  /// interrupt: run_until then returns Status::interrupted. An event that it schedules for this very time happens next. There is
  /// one observer: another one replaces it, an empty one takes it away. Throws Error for a period that is negative, not finite or
  /// shorter than the clock can resolve.
  void observe(double every, std::function<bool(const World&)> observer);

  /// Called after each step with the time, however rarely rows are observed: for a progress bar, or to interrupt by returning
  /// false. There is one watcher, as there is one observer.
  void watch(std::function<bool(double)> watcher);

  /// A function of the world drives a joint from now on: it gives the torque or force (N m, N) along its one freedom, in its
  /// declared direction, on top of what its parameters say; called at every stage of every step, it must not throw, and may
  /// depend on the moment alone. An empty function takes it away. It belongs to the joint: topology changes, snapshots and
  /// branches keep it, until the joint breaks or becomes another. Throws Error for an unknown name, a weld, a joint with
  /// several freedoms, one whose motion is prescribed.
  void drive(std::string_view joint, std::function<double(const EvaluationContext&)> effort);
  /// The same for any number of freedoms: it fills in a list, in the order of v, that comes with zeros.
  void drive_all(std::string_view joint, JointFunction efforts);
  /// The same for many joints at once, at the cost of one evaluation; an error leaves all as they were.
  void drive_all(std::vector<JointDriver> drivers);

  /// A function of the world acts on a body from now on, on top of the model's forces: a wrench about the origin of the body's
  /// frame, in world axes; called at every stage of every step, as that of a drive. What it gives counts as work. It belongs to
  /// the body, whatever that is joined to; snapshots and branches keep it. An empty function takes it away; another replaces it.
  /// Throws Error for an unknown name and for a body that left the world.
  void force(std::string_view body, BodyFunction wrench);

  /// Starts from a state document instead (World::restore); books and events begin anew.
  void restore(double time, const Forest& forest, std::span<const JointStart> joints);

  /// A new body, on any body of the world or on the ground, with the coordinates and velocities of its spec; no velocity of
  /// another body changes, so that a joint at rest takes no energy. Its number, and its joint's, are the next. Throws Error as
  /// Model::add does, and for a joint that would move no mass.
  BodyId add(BodySpec spec);
  /// A body and all bodies outboard of it leave the world; where something holds it, that joint breaks first. Their names and
  /// numbers are not given again. What is scheduled for them is skipped or refused.
  void remove(BodyId body);

  /// Carries out all scheduled events in their order, without moving in between, and takes everything back: which actions will
  /// have nothing to do or are impossible, and which joints there will be. Where events wait for a condition their order is not
  /// known: they are tried in the order of scheduling.
  [[nodiscard]] DryRun dry_run();

  /// All that the run is at this instant: to come back to, across any number of changes, with the very bits.
  [[nodiscard]] SimulationSnapshot snapshot() const;
  /// Events scheduled since then stay scheduled where their time is not past. Observers stay. The snapshot must be of a
  /// simulation of the same model.
  void restore(const SimulationSnapshot& snapshot);
  /// Keeps a snapshot from before every instant at which something happens, from now on.
  void keep_history();
  /// Back to just before the `number`-th of events() happened. Throws Error where the history was not kept. What was scheduled
  /// for that instant does not happen again unless `again`: another branch begins.
  void undo(std::size_t number, bool again = false);
  /// True where the history reaches so far back.
  [[nodiscard]] bool can_undo(std::size_t number) const;
  /// A run of its own from here: world, schedule and books, without observers and history.
  [[nodiscard]] Simulation branch() const;

  StepMemory step_memory() const;
  /// To go on as another run would have: with what its adaptive method remembered (a next step of 0: keep), and where its events
  /// stood, in the order of scheduling (fewer than are scheduled here are fine).
  void resume(std::span<const EventQueue::Armed> armed, const StepMemory& memory = {});

  double time() const;
  const World& world() const;
  const std::vector<Event>& events() const;
  /// Scheduled events that did not happen so far, in the order of scheduling.
  std::vector<MissedEvent> missed() const;
  const RunStatistics& statistics() const;
  EnergyBalance energy() const;
  /// What is wrong, after a Status that is not ok.
  const std::string& message() const;

 private:
  Impl& impl() const;
  Impl& changing() const;
  Impl& scheduling() const;
  Impl& steady() const;
  Scheduled scheduled(EventQueue::Entry entry);
  std::shared_ptr<Impl> impl_;  // shared with no one for longer than a call: handles only look whether it is there
};

}  // namespace momentree
