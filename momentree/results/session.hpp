#pragma once
// From a scenario or model file to a simulation that is ready to run: `auto session = io::load("capture.toml")`.
#include <deque>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <momentree/results/columns/result_columns.hpp>
#include <momentree/scenario/events/schedule.hpp>
#include <momentree/scenario/scenario.hpp>
#include <momentree/scenario/state/state_document.hpp>

namespace momentree::io {

/// A scenario at its start: the model compiled, state documents restored, joints coupled.
class Session {
 public:
  /// `documents`: state documents that replace those of the scenario. Throws Error if a document does not fit the model.
  explicit Session(std::shared_ptr<const Scenario> scenario, std::vector<RestoredState> documents = {});
  explicit Session(Scenario scenario, std::vector<RestoredState> documents = {})
      : Session(std::make_shared<const Scenario>(std::move(scenario)), std::move(documents)) {}

  const Scenario& scenario() const { return *shared_; }

  Simulation& simulation() { return simulation_; }
  const Simulation& simulation() const { return simulation_; }
  /// Schedules the events that have not happened yet, once; load() has done so. Returns warnings about events that are too late
  /// or have no effect left, and about start values of documents that loops and couplings don't allow. Throws Error for the first
  /// event that is impossible in the world of a state document.
  [[nodiscard]] std::vector<Diagnostic> schedule();
  /// How often each event has happened, including before the start according to the state document.
  Armed armed() const { return armed(simulation_); }
  /// The same of a branch of the simulation.
  Armed armed(const Simulation& branch) const;
  /// Runs to the end of the scenario.
  RunResult run();
  /// Every joint that exists, or that scheduled events will make.
  std::vector<JointKinds> joints();

  /// Of the file and of schedule(), for a session that load() made.
  std::vector<Diagnostic> warnings;

 private:
  void take_armed(const ArmedEvent& event, const std::string& file);
  const EventStatus* past_of(const ScenarioEvent& event) const;
  bool has_happened(const ScenarioEvent& event) const;
  void resume();
  void schedule_followers(std::vector<const ScenarioEvent*>& events);
  const ScenarioEvent& original(const ScenarioEvent& event) const;

  std::shared_ptr<const Scenario> shared_;
  Simulation simulation_;
  Armed armed_at_start_;
  StepMemory memory_;
  std::vector<Diagnostic> of_documents_;  // warnings
  Schedule scheduled_;
  std::unordered_map<std::string, std::size_t> by_name_;            // indices in armed_at_start_
  std::vector<std::vector<const ScenarioEvent*>> matches_;          // by index
  std::unordered_map<const ScenarioEvent*, std::size_t> match_of_;  // the index of the match
  // Events that follow completed ones and are due, as events with an instant.
  std::deque<ScenarioEvent> pending_;
  std::unordered_map<const ScenarioEvent*, const ScenarioEvent*> original_;
  bool from_document_ = false, has_events_ = false;
};

struct LoadOptions {
  std::vector<std::string> overrides{};  ///< KEY=VALUE, as the command's --set
  std::string state{};                   ///< a state document that replaces those of the scenario
};

/// Reads a scenario (TOML) or model (URDF, SDF, MJCF) file and makes it ready to run, its events scheduled. Throws InputError
/// if the file has errors, and Error for a state document or an event that does not fit.
[[nodiscard]] Session load(const std::string& path, const LoadOptions& options = {});
/// The same from a text; files that it names are located in the working folder. `name`: for messages.
[[nodiscard]] Session load_text(std::string text, const std::string& name, const LoadOptions& options = {});

}  // namespace momentree::io
