#pragma once
// From a scenario file to a simulation that is ready to run: shared by `run`, `check`, `evaluate` and `explain`.
#include <deque>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <cli/input.hpp>
#include <momentree/io/result_columns.hpp>
#include <momentree/io/scenario.hpp>
#include <momentree/io/schedule.hpp>
#include <momentree/io/state_document.hpp>

namespace momentree::cli {

/// Reads a scenario or a model, from standard input if the path is "-". Prints diagnostics of severity `least` or worse to
/// standard error; of notes on model files only the number, unless they are to be `listed`. Empty if there are errors.
std::optional<io::Scenario> load(const std::string& path, const std::vector<std::string>& overrides, Notes notes = Notes::counted,
                                 io::Severity least = io::Severity::note);
inline Notes notes_of(bool verbose) { return verbose ? Notes::listed : Notes::counted; }

/// Throws Error if the output file is the scenario, or a model or state document that it names. "-" is standard output.
void refuse_to_overwrite(const std::string& out, const io::Scenario& scenario);

/// A scenario at its start: the model compiled, state documents restored.
class Session {
 public:
  /// `state`: a state document that replaces those of the scenario, "-" for standard input; empty: none. Throws Error if a
  /// document is invalid.
  explicit Session(const io::Scenario& scenario, const std::string& state = "");

  Simulation& simulation() { return simulation_; }
  const Simulation& simulation() const { return simulation_; }
  /// Schedules the events that have not happened yet. Returns warnings about events that are too late or have no effect left.
  /// Throws Error for the first event that is impossible in the world of a state document.
  [[nodiscard]] std::vector<io::Diagnostic> schedule();
  /// How often each event has happened, including before the start according to the state document.
  io::Armed armed() const;
  /// Every joint that exists, or that scheduled events will make.
  std::vector<io::JointKinds> joints();

 private:
  io::RestoredState read(const std::string& text, const io::StateFile& document) const;
  void take_armed(const io::ArmedEvent& event, const std::string& file);
  const EventQueue::Armed* past_of(const io::ScenarioEvent& event) const;
  void resume();
  void schedule_followers(std::vector<const io::ScenarioEvent*>& events);
  const io::ScenarioEvent& original(const io::ScenarioEvent& event) const;

  const io::Scenario& scenario_;
  Simulation simulation_;
  io::Armed armed_at_start_;
  StepMemory memory_;
  io::Schedule scheduled_;
  std::unordered_map<std::string, std::size_t> by_name_;                // indices in armed_at_start_
  std::vector<std::vector<const io::ScenarioEvent*>> matches_;          // by index
  std::unordered_map<const io::ScenarioEvent*, std::size_t> match_of_;  // the index of the match
  // Events that follow completed ones and are due, as events with an instant.
  std::deque<io::ScenarioEvent> pending_;
  std::unordered_map<const io::ScenarioEvent*, const io::ScenarioEvent*> original_;
  bool from_document_ = false;
};

}  // namespace momentree::cli
