#pragma once
// A run between two steps: everything that its continuation depends on.
#include <string>
#include <vector>

#include <momentree/simulate/events/event_queue.hpp>
#include <momentree/simulate/events/stops.hpp>
#include <momentree/simulate/failure.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {

/// The status of all events of a queue, scheduled ones and strengths of joints, and what stops remember.
struct QueueState {
  using Entry = EventQueue::Progress;
  /// The event of a joint's strength, with the names that it had when the strength was found.
  struct Borne {
    Strength strength{};
    std::string event, joint;
    Entry entry;
  };
  std::vector<Entry> entries;  ///< in the order of scheduling
  std::vector<Borne> strengths;
  bool strengths_known = false;  ///< `strengths` are those of the present topology
  std::vector<DeeperStop> deeper_stops;
  double next = HUGE_VAL;  ///< the next instant at which something may be due (s)
};

/// A run between two steps. A simulation of the same model with the same events, functions and gravity continues from it as the
/// run itself would, to the last bit of every state, event and count; only wall-clock times differ.
struct RunState {
  WorldSnapshot world;
  QueueState queue;
  EnergyBalance balance;            ///< without the ledger of the method:
  double dissipated = 0, work = 0;  ///< energy dissipated and work done in steps since the start (J)
  double proposal = 0;              ///< the next step of an adaptive method (s)
  double impacts = 0;               ///< energy lost at contacts in steps since the start (J)
  SteppingState stepping{};
  bool evaluated = false;          ///< the state has been evaluated, and that was counted
  long evaluations = 0;            ///< not yet in `statistics`
  double evaluation_seconds = 0;   ///< likewise (s)
  RunStatistics statistics;        ///< including the wall-clock time up to now
  ProgressMonitor::Mark progress;  ///< where the run was when its progress was last checked
  bool within_run = false;         ///< run_until() was in progress: the next one continues it
  bool keeps_closed = false;       ///< or the next one may begin with the closed contacts
  bool observed = false;           ///< the observer has been called,
  double observed_at = 0;          ///< last at this time (s)
  double next_observation = 0;     ///< s
  std::vector<Event> events;       ///< those that happened
};

/// The scheduled events, in the order of scheduling.
const std::vector<EventQueue::Entry>& scheduled(const Simulation& simulation);
/// Replaces them, before continue_from(). Names are not checked: the events may refer to what the run made later.
void schedule(Simulation& simulation, std::vector<EventQueue::Entry> events);

}  // namespace momentree
