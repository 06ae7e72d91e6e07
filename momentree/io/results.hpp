#pragma once
// The files of a run: bodies.csv, joints.csv, energy.csv, events.jsonl, final.json, summary.json, model.json, report.html.
#include <chrono>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/io/result_columns.hpp>
#include <momentree/io/result_directory.hpp>
#include <momentree/io/state_document.hpp>
#include <momentree/io/summary.hpp>
#include <momentree/io/text_file.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

struct RecordOptions {
  std::string directory;
  std::vector<JointKinds> joints = {};  ///< those that have columns
  double every = 0;                     ///< time between rows (s); 0: a row for each observation
  bool reactions = false;               ///< in joints.csv, too
  bool energy = true;                   ///< energy.csv
  bool report = false;                  ///< finish() will be given one
  bool lasting = true;                  ///< see ResultDirectory
};

/// The page for report.html, from the folder as it is then and from the text of summary.json, which is written after it.
using ReportPage = std::function<std::string(const std::filesystem::path& folder, const std::string& summary)>;

/// Writes the rows and events while a run goes on. Give `observe` to Simulation::observe. What has an instant in a table has its
/// events in events.jsonl: those are handed to the system first, every second at the latest.
class Recorder {
 public:
  /// Makes the folder, model.json and the heads of the tables; summary.json says that the run goes on. Throws Error, and leaves
  /// nothing behind, where that can't be done. The simulation must live as long as this, and be the one whose world is observed.
  Recorder(const Simulation& simulation, RunOrigin origin, std::string_view model_json, RecordOptions options);
  /// Abandons a run that was not finished.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// A row of each table where one is due. Of several observations at one instant the last counts: the state after the events.
  /// Returns false where it could not be written (a full disk): `error` says why.
  bool observe(const World& world) noexcept;

  /// Ends the tables with the final state and writes the other files, summary.json last; then a run that is `done` is moved to
  /// its place. Where anything can't be written, `error` says what and the status becomes "failed: …"; all else is kept.
  void finish(const std::string& status, const Armed& armed, const ReportPage& report = {});
  /// Ends a run whose simulation can't be trusted any more: the rows so far are kept, with that status.
  void abandon(const char* status) noexcept;

  /// The first thing that could not be written, or moved to its place.
  const std::optional<Error>& error() const { return error_; }
  /// As it stands in summary.json, after finish: why a run failed, or "done".
  const std::string& status() const { return status_; }
  /// The text of summary.json, after finish.
  const std::string& summary() const { return summary_; }
  /// What of an earlier result could not be moved or removed.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Whether the result is whole and in its place: only then was the run done.
  bool is_published() const { return published_; }
  bool has_report() const { return has_report_; }
  /// After finish: where the result stands. Before: where it is being written.
  std::string directory() const;

 private:
  using Clock = std::chrono::steady_clock;

  bool due(double time);
  void write_row(const World& world);
  void write_out_where_due();
  void take_events();
  void close_tables();
  std::string reason() const;
  void seal(const std::string& status, const ReportPage& report);
  template <class Action>
  bool attempt(const Action& action) noexcept;
  void note(const char* what) noexcept;

  const Simulation& simulation_;
  const RunOrigin origin_;
  const RecordOptions options_;
  ResultDirectory directory_;
  TextFile events_, bodies_, joints_;  // after the folder that they are in
  std::optional<TextFile> energy_;
  BodyColumns body_columns_;
  JointColumns joint_columns_;
  double next_ = -std::numeric_limits<double>::infinity();  ///< multiple of options_.every at which the next row is due
  std::optional<double> row_time_;
  std::size_t body_row_ = 0, joint_row_ = 0, energy_row_ = 0;  ///< where the last row begins in the buffers
  std::size_t events_taken_ = 0;                               ///< how many are in events.jsonl or its buffer
  Clock::time_point written_out_ = Clock::now();
  std::optional<Error> error_;
  std::string status_, summary_;
  std::vector<std::string> warnings_;
  bool failed_ = false, has_report_ = false, published_ = false;
  bool sealed_ = false;  ///< summary.json has the final status
};

}  // namespace momentree::io
