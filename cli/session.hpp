#pragma once
// From a scenario file to a simulation that is ready to run: what `run`, `check`, `evaluate` and `explain` have in common.
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

/// Reads a scenario or a model, from standard input where the path is "-"; what is as grave as `least` or worse is said on
/// standard error, notes on model files by their number alone unless they are to be `listed`. Where it has errors, the result is
/// empty.
std::optional<io::Scenario> load(const std::string& path, const std::vector<std::string>& overrides, Notes notes = Notes::counted,
                                 io::Severity least = io::Severity::note);
inline Notes notes_of(bool verbose) { return verbose ? Notes::listed : Notes::counted; }

/// Throws Error where the file to write is the scenario, or a model or state document that it names. "-" is standard output.
void refuse_to_overwrite(const std::string& out, const io::Scenario& scenario);

/// A scenario at its start: model compiled, state documents restored.
class Session {
 public:
  /// `state`: a state document that replaces those of the scenario, "-" on standard input; empty: none. Throws Error for what is
  /// wrong with a document.
  explicit Session(const io::Scenario& scenario, const std::string& state = "");

  Simulation& simulation() { return simulation_; }
  const Simulation& simulation() const { return simulation_; }
  /// Schedules the events that have not happened yet. Returns warnings: which are too late, and which have nothing left to do.
  /// Throws Error for the first that will be impossible in the world that a state document made.
  [[nodiscard]] std::vector<io::Diagnostic> schedule();
  /// How often each event has happened: before the start, by the state document, and since.
  io::Armed armed() const;
  /// Every joint that there is or, by the events that are scheduled, will be.
  std::vector<io::JointKinds> joints();

 private:
  void read(const io::StateFile& document, std::vector<io::RestoredState>& documents) const;
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
  std::unordered_map<std::string, std::size_t> by_name_;                // places in armed_at_start_
  std::vector<std::vector<const io::ScenarioEvent*>> matches_;          // by place
  std::unordered_map<const io::ScenarioEvent*, std::size_t> match_of_;  // which of the matches it is
  // Of what comes after events that are over, and is due: as events at that instant.
  std::deque<io::ScenarioEvent> pending_;
  std::unordered_map<const io::ScenarioEvent*, const io::ScenarioEvent*> original_;
  bool from_document_ = false;
};

}  // namespace momentree::cli
