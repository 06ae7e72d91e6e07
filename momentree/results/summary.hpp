#pragma once
// summary.json and the lines of events.jsonl.
#include <span>
#include <string>
#include <vector>

#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

/// The origin of a result.
struct RunOrigin {
  std::string name, title;
  std::string file;                    ///< the scenario, as the user named it
  std::string hash;                    ///< of its text and the overrides: identifies the input
  std::vector<std::string> overrides;  ///< "integrate.step=1e-4"
  double start = 0, until = 0;         ///< s
  Integration integration;             ///< with the variables of the run's world
  bool reactions = false;              ///< joints.csv has them
  std::size_t first_event = 0;         ///< events of the simulation that happened before
};

/// Of a run of the scenario that starts at the present state of the simulation.
RunOrigin run_origin(const Scenario& scenario, const Simulation& simulation, double until);

/// `summary.json`: `status` is "done", or why the run ended early.
std::string summary_json(const RunOrigin& origin, const std::string& status, const Simulation& simulation);

/// Like the above, without results: for a run in progress, or one that stopped with an invalid simulation.
std::string summary_json(const RunOrigin& origin, const std::string& status);

/// What a user should know about a run that ended: actions that did nothing, one warning for each event that has some, and
/// Simulation::warnings().
std::vector<std::string> run_warnings(const RunOrigin& origin, const Simulation& simulation);

/// Events that did not happen: of the matches of a wildcard the one that came nearest, and none of them if one happened.
std::vector<MissedEvent> missed_events(const Simulation& simulation);

/// One line of `events.jsonl`.
std::string event_json(const Event& event);

}  // namespace momentree::io
