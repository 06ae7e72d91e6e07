#pragma once
// The files of a run that grow: its events, and its tables, row by row. Both recorders write them: during the run (results.hpp),
// and from rows in memory (run_record.hpp).
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <momentree/results/checkpoint/checkpoint.hpp>
#include <momentree/results/columns/result_columns.hpp>
#include <momentree/results/result_directory.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {

/// What the tables have; springs.csv is there if the model has springs.
struct TableChoice {
  std::vector<JointKinds> joints{};  ///< the joints that get columns
  bool reactions = false;            ///< in joints.csv
  bool energy = true;                ///< energy.csv
  bool contacts = false;             ///< contacts.csv
};

class RunTables {
 public:
  /// events.jsonl, then the tables.
  static std::vector<std::string> files(const Model& model, const TableChoice& choice);
  /// Whether these tables can continue those of a checkpoint.
  static bool fit(const World& start, const TableChoice& choice, const RecorderState& from);

  /// Makes the files, with headers in their buffers, or continues those of a checkpoint. `start`: the world whose bodies get
  /// columns. `keep_checksums`: for save().
  RunTables(ResultDirectory& folder, const World& start, const TableChoice& choice, bool keep_checksums = false,
            const RecorderState* from = nullptr);
  RunTables(const RunTables&) = delete;
  RunTables& operator=(const RunTables&) = delete;

  void add(const Event& event);
  /// Adds a row to each table, or replaces the last one. If an error is thrown, none of them has it.
  void row(const World& world, const EnergyBalance& balance, bool replaces = false);

  /// Whether the buffer of a table has grown so large that it should be written.
  bool is_full() const;
  /// Writes the buffers out, that of the events first.
  void flush();
  /// Writes the buffers out but for the last rows, which others of the same instant may replace, and fills in the files.
  void save(RecorderState& state);

  TextFile& events() { return files_.front().file; }
  using Row = std::function<void(std::string& text, const World& world, const EnergyBalance& balance)>;
  struct File {
    std::string name;
    TextFile file;
    Row row;
    std::size_t last = 0;  ///< offset of the last row in the buffer
  };
  std::span<File> tables() { return std::span(files_).subspan(1); }

 private:
  BodyColumns bodies_;
  JointColumns joints_;
  std::vector<int> places_;  ///< by body: its place in bodies.csv; −1: none
  bool all_have_places_ = true;
  std::vector<File> files_;  ///< in the order of files()
};

}  // namespace momentree::io
