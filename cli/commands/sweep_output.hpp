#pragma once
// Where a sweep's results go: the journal while it runs, and the tables when it is complete.
#include <optional>
#include <string>
#include <vector>

#include <cli/commands.hpp>
#include <momentree/results/result_directory.hpp>
#include <momentree/sweep/journal.hpp>
#include <momentree/sweep/lanes.hpp>
#include <momentree/sweep/summary.hpp>

namespace momentree::cli {

/// Whether the results go into one HDF5 file.
bool is_one_file(const std::string& destination);
/// The text of sweep.json in complete results, of whatever sweep; empty if there are none. Throws Error.
std::string complete_summary(const std::string& out);

/// The folder `OUT.partial` with the journal. Without publish() it is kept, so that the sweep can be continued.
class SweepOutput {
 public:
  /// Opens the journal of an interrupted sweep, or begins a new one. Throws Error if the folder holds the journal of another
  /// sweep and `options` do not say what to do with it, or if it cannot be written; nothing has then changed.
  SweepOutput(const sweep::Sweep& sweep, sweep::Lanes lanes, const SweepOptions& options);

  /// Where the results will be: a folder, or a file that ends in .h5.
  const std::string& destination() const { return out_; }
  std::string working() const { return folder_->working().string(); }
  sweep::Journal& journal() { return *journal_; }
  /// Worlds of an earlier run that were found.
  std::uint64_t found() const { return found_; }

  /// Writes the tables from the complete journal and moves them to their destination. Returns warnings; nothing if it
  /// was interrupted while the report was written. The journal is then still there, and so it is if this throws Error.
  std::optional<std::vector<std::string>> publish(bool report);
  /// The statistics, after publish().
  const sweep::SweepSummary& summary() const { return *summary_; }

 private:
  bool in_one_file() const { return is_one_file(out_); }
  void try_table();
  void restore(const sweep::JournalIdentity& wanted);
  void write_tables();
  void write_hdf5();
  bool write_report(std::vector<std::string>& warnings);
  std::string page_of(std::uint64_t world) const;

  const sweep::Sweep& sweep_;
  std::string out_;
  std::optional<io::ResultDirectory> folder_;
  std::optional<sweep::Journal> journal_;
  std::optional<sweep::SweepSummary> summary_;
  std::uint64_t found_ = 0;
};

/// Whether a report is wanted that complete results do not have.
bool needs_report(const std::string& out, const SweepOptions& options);
/// The destination of a sweep: --out, the sweep's own, or results/ and its name.
std::string sweep_destination(const sweep::Sweep& sweep, const SweepOptions& options);
/// Whether the folder or file holds the complete result of this sweep, computed by this version.
bool is_complete_sweep(const sweep::Sweep& sweep, const std::string& out);

}  // namespace momentree::cli
