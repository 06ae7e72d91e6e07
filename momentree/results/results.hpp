#pragma once
// Writes the files of a run: bodies.csv, joints.csv, energy.csv and, of a model with springs, springs.csv (or these as
// results.h5), with reactions of bodies that can touch contacts.csv, events.jsonl, final.json, summary.json, model.json, of a
// model with meshes meshes.json, report.html.
#include <chrono>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/results/checkpoint/checkpoint.hpp>
#include <momentree/results/columns/result_columns.hpp>
#include <momentree/results/result_directory.hpp>
#include <momentree/results/run_tables.hpp>
#include <momentree/results/summary.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {

struct RecordOptions {
  std::string directory;
  std::vector<JointKinds> joints = {};  ///< the joints that get columns
  double every = 0;                     ///< time between rows (s); 0: a row for each observation
  bool reactions = false;               ///< in joints.csv, and contacts.csv if bodies can touch
  bool energy = true;                   ///< write energy.csv
  bool report = false;                  ///< finish() will be given a report page
  bool lasting = true;                  ///< see ResultDirectory
  bool hdf5 = false;                    ///< a complete run gets results.h5 in place of the tables
  std::string meshes = {};              ///< the content of meshes.json; empty: there are none
  std::optional<RunInput> input = {};   ///< given: checkpoints of this input can be written
};

/// Builds report.html from the folder in its current state and the text of summary.json, which is written afterwards.
using ReportPage = std::function<std::string(const std::filesystem::path& folder, const std::string& summary)>;

/// Writes the rows and events during a run. Pass `observe` to Simulation::observe. The events up to the instant of a row are
/// always in events.jsonl: events are written before the tables are flushed, at least every second, and before checkpoints.
class Recorder {
 public:
  /// Makes the folder, model.json and the headers of the tables; summary.json reports that the run is in progress. Throws
  /// Error, and leaves nothing behind, if that fails. The simulation must outlive this object and own the world that is
  /// observed.
  Recorder(const Simulation& simulation, RunOrigin origin, std::string_view model_json, RecordOptions options);
  /// Continues the tables of a run that ended early, whose folder it takes over. The simulation is at its start, set up as that
  /// run was; call continue_run() once it is observed. Throws Error if the checkpoint does not fit, with nothing changed.
  Recorder(const Simulation& simulation, RunOrigin origin, RecordOptions options, Interrupted& from);
  /// Abandons a run that was not finished.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Writes a row of each table if one is due. Of several observations at one instant the last counts: the state after the
  /// events. Returns false if the row could not be written (a full disk); `error` then gives the reason.
  bool observe(const World& world) noexcept;

  /// Writes a checkpoint of the run, with everything before it flushed to disk; call it where Simulation::run_state may be
  /// called. `every`: the wall-clock time between checkpoints (s), for a continuation. If only the checkpoint cannot be written,
  /// the former one stays and a warning says so. Returns false if a table could not be written: `error` then gives the reason.
  bool save(double every) noexcept;

  /// Ends the tables with the final state and writes the other files, summary.json last; a run with status `done` is then moved
  /// to its destination. If anything cannot be written, `error` gives the reason and the status becomes "failed: …"; everything
  /// else is kept.
  void finish(const std::string& status, const Armed& armed, const ReportPage& report = {});
  /// Ends a run whose simulation is no longer valid: the rows so far are kept, with that status.
  void abandon(const char* status) noexcept;

  /// The first failure to write a file or to move the result to its destination.
  const std::optional<Error>& error() const { return error_; }
  /// The status in summary.json, after finish: "done", or why the run failed.
  const std::string& status() const { return status_; }
  /// The text of summary.json, after finish.
  const std::string& summary() const { return summary_; }
  /// Files of an earlier result that could not be moved or removed.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Whether the result is complete and in its destination: only then is the run done.
  bool is_published() const { return published_; }
  bool has_report() const { return has_report_; }
  /// After finish: the location of the result. Before: the folder that is being written.
  std::string directory() const;

 private:
  using Clock = std::chrono::steady_clock;

  bool due(double time);
  Recorder(const Simulation& simulation, RunOrigin origin, RecordOptions options, std::unique_ptr<ResultDirectory> directory,
           const RecorderState* from);
  void write_running_summary();
  void write_row(const World& world);
  RecorderState state();
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
  const std::unique_ptr<ResultDirectory> directory_;
  RunTables tables_;                                        // declared after the folder that contains them
  double next_ = -std::numeric_limits<double>::infinity();  ///< multiple of options_.every at which the next row is due
  std::optional<double> row_time_;
  std::size_t events_taken_ = 0;  ///< the number of events in events.jsonl or its buffer
  Clock::time_point written_out_ = Clock::now();
  std::optional<Error> error_;
  std::string status_, summary_;
  std::vector<std::string> warnings_;
  bool failed_ = false, has_report_ = false, published_ = false;
  bool sealed_ = false;  ///< summary.json has the final status
};

}  // namespace momentree::io
