#pragma once
// The files of a run: bodies.csv, joints.csv, energy.csv, events.jsonl, final.json, summary.json, model.json.
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <momentree/io/result_columns.hpp>
#include <momentree/io/result_directory.hpp>
#include <momentree/io/state_document.hpp>
#include <momentree/io/text_file.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

/// What a result says of where it came from.
struct RunOrigin {
  std::string name, title;
  std::string file;                    ///< the scenario, as the user named it
  std::string hash;                    ///< of its text and the overrides: names the input
  std::vector<std::string> overrides;  ///< "integrate.step=1e-4"
  double start = 0, until = 0;         ///< s
  Integration integration;
};

/// `summary.json`: `status` is "done", or why the run ended before its time.
std::string summary_json(const RunOrigin& origin, const std::string& status, const Simulation& simulation);

/// Events that did not happen: of the matches of a wildcard the one that came nearest, none where one of them happened.
std::vector<MissedEvent> missed_events(const Simulation& simulation);

/// One line of `events.jsonl`.
std::string event_json(const Event& event);

/// Writes the rows while a run goes on. Give `observe` to Simulation::observe.
class Recorder {
 public:
  /// Makes the folder and the heads of the tables. `joints`: those that have columns; `every`: time between rows (s), 0 for each
  /// observation; `reactions`: joints.csv has them, too. Throws Error where the folder can't be had.
  Recorder(const Model& model, std::vector<JointKinds> joints, double every, const std::string& directory,
           bool reactions = false);

  /// Rows go to energy.csv, too. The simulation must live as long as this, and be the one whose world is observed.
  void record_energy(const Simulation& simulation);

  /// A row of each table where one is due. Of several observations at one instant the last counts: the state after the events.
  /// Returns false where it could not be written (a full disk): `error` says why.
  bool observe(const World& world) noexcept;
  const std::optional<Error>& error() const { return error_; }

  /// Ends the tables with the final state and writes the other files; a run that is `done` is moved to its place, after `last`
  /// has been called with the folder that holds it now (a report of all that is there).
  /// Throws Error where something could not be written; the folder then stays as it is, `.partial`.
  void finish(const RunOrigin& origin, const std::string& status, const Simulation& simulation, const Armed& armed,
              const std::string& model_json, const std::function<void(const std::filesystem::path&)>& last = {});

  /// After finish: where the result stands. Before: where it is being written.
  std::string directory() const;

 private:
  bool due(double time);
  void write_row(const World& world);

  ResultDirectory directory_;
  TextFile bodies_, joints_;  // after the folder that they are in
  std::optional<TextFile> energy_;
  const Simulation* books_ = nullptr;  ///< whose energy is recorded
  BodyColumns body_columns_;
  JointColumns joint_columns_;
  double every_;
  double next_ = -std::numeric_limits<double>::infinity();  ///< multiple of every_ at which the next row is due
  std::optional<double> row_time_;
  std::size_t body_row_ = 0, joint_row_ = 0, energy_row_ = 0;  ///< where the last row begins in the buffers
  std::optional<Error> error_;
  bool published_ = false;
};

}  // namespace momentree::io
