#pragma once
// Converts the events of a scenario into events of a simulation, and the findings of a dry run into places in the file.
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <momentree/scenario/scenario.hpp>

namespace momentree::io {

/// A problem of an action.
struct EventProblem {
  Place place;
  std::string what, hint;
  /// The run continues: the action has no effect, or applies to another joint than the one that it seems to name.
  bool idle = false;
};

/// Events in the order in which they were scheduled: by time, and as in the file for equal times.
struct Schedule {
  std::vector<const ScenarioEvent*> events;
  std::vector<EventProblem> problems;  ///< unknown names
  std::set<std::string> springs{};     ///< names of the model's springs
};
/// Conditions and actions may name joints that any of these events makes, or one of `past`: events that have happened already.
Schedule schedule(Simulation& simulation, std::vector<const ScenarioEvent*> events, const std::vector<ScenarioEvent>& past = {});

/// The findings of a dry run of everything scheduled: actions that will be impossible, or have no effect although they name a
/// joint without a wildcard. `name_of` names a second place in the message: "line 12".
std::vector<EventProblem> problems_of(const DryRun& dry_run, const Schedule& schedule,
                                      const std::function<std::string(Place)>& name_of);

}  // namespace momentree::io
