#pragma once
// From the events of a scenario to those of a simulation, and back from what a rehearsal finds to places in the file.
#include <functional>
#include <string>
#include <vector>

#include <momentree/io/scenario.hpp>

namespace momentree::io {

/// What is wrong with an action.
struct EventProblem {
  Place place;
  std::string what, hint;
  /// A run goes on past it: it has nothing to do, or meets another joint than the one that it seems to name.
  bool idle = false;
};

/// Events in the order in which they were scheduled: that of time, and of the file where times are equal.
struct Schedule {
  std::vector<const ScenarioEvent*> events;
  std::vector<EventProblem> problems;  ///< unknown names
};
/// Their conditions and actions may name joints that any of them makes, or one of `past`: events that have happened already.
Schedule schedule(Simulation& simulation, std::vector<const ScenarioEvent*> events, const std::vector<ScenarioEvent>& past = {});

/// Carries everything out that is scheduled (Simulation::rehearse): what will be impossible, or will do nothing though it was
/// named without a wildcard. `name_of` says where a second place is: "line 12".
std::vector<EventProblem> problems_of(const DryRun& dry_run, const Schedule& schedule,
                                      const std::function<std::string(Place)>& name_of);

}  // namespace momentree::io
