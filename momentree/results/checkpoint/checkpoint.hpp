#pragma once
// Checkpoints: a run in a file, from which it can be continued after its process has ended.
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/results/result_directory.hpp>
#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/run_state.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {

/// What a checkpoint belongs to: it is refused for anything else.
struct RunInput {
  std::string version;     ///< of the program
  std::string scenario;    ///< Scenario::hash: text, overrides and model files
  std::string documents;   ///< checksum of the state documents that the scenario names
  bool reactions = false;  ///< joints.csv has the reactions
  friend bool operator==(const RunInput&, const RunInput&) = default;
};
/// For this program. Reads the state documents; throws Error.
RunInput run_input(const Scenario& scenario, bool reactions);

/// The state of a Recorder.
struct RecorderState {
  /// A table: what is in its file, and the last row, which is written only once it is final.
  struct Table {
    std::string file;
    TextFile::Mark mark;
    std::string last;
  };
  std::vector<Table> tables;  ///< events.jsonl first
  double next = -std::numeric_limits<double>::infinity();
  std::optional<double> row_time;
  std::size_t events_taken = 0;
  std::vector<Quat> body_quaternions, joint_quaternions;
};

struct Checkpoint {
  RunInput input;
  double every = 0;  ///< wall-clock time between two checkpoints (s)
  RunState run;
  RecorderState record;
  // Of a run that a program has set up:
  std::vector<EventQueue::Entry> scheduled{};                  ///< its events, of which scenarios have their own
  std::vector<std::pair<int, std::vector<double>>> efforts{};  ///< by joint number (N m, N)
};

/// What checkpoints are called in messages, and what helps if one can't be used.
struct CheckpointWords {
  const char* name = "this checkpoint";
  const char* again = "run without --resume to start again from the beginning";
  const char* other_version = "resume with the version that wrote it, or run without --resume";
};

/// The content of a file: magic number, format version, length, data, checksum.
std::string sealed(const std::string& data);
/// Its data; `path` is for messages. Throws Error, with a remedy, for anything else.
std::string_view unsealed(std::string_view bytes, const std::string& path, const CheckpointWords& words);

/// The content of a checkpoint file. Throws Error for scheduled events that depend on functions.
std::string checkpoint_bytes(const Checkpoint& checkpoint);
/// Reads one; `path` is for messages. Throws Error, with a remedy, for anything but a whole checkpoint of this format.
Checkpoint read_checkpoint(std::string_view bytes, const std::string& path, const CheckpointWords& words = {});

/// Throws Error if the simulation has another model or other events than the run of the checkpoint; `path` is for messages.
void require_fit(const Simulation& simulation, const Checkpoint& checkpoint, const std::string& path,
                 const CheckpointWords& words = {});
/// Continues the run of a checkpoint that fits in a simulation that has been set up as that run was: see
/// Simulation::continue_from. Functions, such as those of couplings, are those of the simulation unless the checkpoint was given
/// some.
void continue_run(Simulation& simulation, const Checkpoint& checkpoint);

/// The folder and the checkpoint of a run that ended early.
struct Interrupted {
  std::unique_ptr<ResultDirectory> directory;
  Checkpoint checkpoint;
  std::string path;  ///< of the checkpoint
};
/// Finds the checkpoint of a run into `destination`; nothing if there is none. Throws Error, with nothing changed, for a
/// checkpoint that is damaged or of another input, and for tables that were changed since.
std::optional<Interrupted> find_checkpoint(const std::string& destination, const RunInput& input);

/// True if `destination` has the complete result of that input by this program. A checkpoint is removed from it: that of a run
/// that was killed after it published its result. Throws Error, also if it lacks the reactions that the input asks for.
bool is_complete(const std::string& destination, const RunInput& input);

}  // namespace momentree::io
