#pragma once
// bodies.csv: poses of all bodies at chosen instants.
#include <filesystem>
#include <string>
#include <vector>

#include <momentree/results/recording/number_table.hpp>
#include <momentree/results/recording/recording.hpp>

namespace momentree::io {

class BodyTable {
 public:
  /// Reads the header and the times. Throws Error as NumberTable does, and if columns are missing or there is no complete row.
  explicit BodyTable(const std::filesystem::path& file);

  /// In the order of the columns.
  const std::vector<std::string>& bodies() const { return bodies_; }
  const std::vector<double>& times() const { return table_.times(); }

  /// The row nearest to `time` (s); of several at one instant the last (after the events of that instant).
  std::size_t row_near(double time) const;
  /// Of the rows with these indices (ascending): x y z qw qx qy qz of each body. The numbers of a run that diverged may not be
  /// finite. Throws Error as NumberTable::read does.
  std::vector<double> poses(const std::vector<std::size_t>& rows) const { return in_order(table_.read(rows)); }
  std::vector<double> poses() const { return in_order(table_.read()); }  ///< of all rows
  /// The same as frames. Throws Error also for poses that are not finite.
  std::vector<RecordedFrame> read(const std::vector<std::size_t>& rows) const;

 private:
  std::vector<double> in_order(const std::vector<double>& cells) const;

  NumberTable table_;
  std::vector<std::string> bodies_;
  std::vector<std::size_t> at_;  // by body, seven column indices
};

/// The rows for one frame every `every` seconds, beginning with the first row; see read_recording for 0. Sets `every` to the
/// value used.
std::vector<std::size_t> choose_rows(const BodyTable& table, double& every);

}  // namespace momentree::io
