#pragma once
// A world that runs: model, state, scheduled events, books.
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/simulate/action.hpp>
#include <momentree/simulate/event.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

/// How to step. `method`: "rk4".
struct Integration {
  std::string method = "rk4";
  double step = 1e-3;              ///< s
  double event_tolerance = 1e-10;  ///< s
};

enum class Status { ok, diverged, interrupted };

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
};

class Simulation {
  struct Impl;

 public:
  /// Compiles the model. Throws Error: an unknown method, step ≤ 0, a singular joint-space mass.
  explicit Simulation(const Model& model, const Integration& integration = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Schedules actions for an instant not yet past: `at(1.8).then(break_joint("chain/41"))`. Events of one instant happen in the
  /// order in which they were scheduled. Throws Error for an unknown name or a time that is past or not finite.
  class Scheduled {
   public:
    Scheduled& then(Action action);
    Scheduled& named(std::string name);

   private:
    friend class Simulation;
    Scheduled(Impl& impl, void* event) : impl_(&impl), event_(event) {}
    Impl* impl_;
    void* event_;
  };
  Scheduled at(double time);

  /// Steps to `time`, exactly onto every scheduled event and `time`; events at `time` happen. On divergence the state is the last
  /// good one and `message()` says which joint, when, and what to do.
  Status run_until(double time);
  /// One step of `dt` seconds for a loop of one's own (events inside it happen at their instants).
  Status step(double dt);

  /// Called when run_until first starts, then at every multiple of `every` seconds (after each step if 0), and when run_until
  /// ends; never twice at one time; where events happen at that time, after them. Steps land on these instants. The world may be
  /// read. Return false to interrupt: run_until then returns Status::interrupted.
  void observe(double every, std::function<bool(const World&)> observer);

  /// Called after each step with the time, however rarely rows are observed: for a progress bar, or to interrupt by returning
  /// false.
  void watch(std::function<bool(double)> watcher);

  /// Starts from a state document instead (World::restore); books and events begin anew.
  void restore(double time, std::span<const Body> broken, std::span<const JointStart> joints);

  double time() const;
  const World& world() const;
  const std::vector<Event>& events() const;
  const RunStatistics& statistics() const;
  EnergyBalance energy() const;
  const std::string& message() const;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace momentree
