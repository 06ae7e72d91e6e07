#pragma once
// A table of numbers with the time in its first column, as a run writes it. The file is read as a stream, since it may be
// large.
#include <filesystem>
#include <string>
#include <vector>

namespace momentree::io {

class NumberTable {
 public:
  /// Reads the header and the times. A last line without a line end is left out: an interrupted run was still writing it.
  /// Throws Error: a missing file, a first column that is not `time`, a time that is not a number.
  explicit NumberTable(std::filesystem::path file);

  /// Without `time`.
  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<double>& times() const { return times_; }

  /// The numbers of these rows (ascending), row by row; NaN for an empty cell, infinity for a value that is not finite. Throws
  /// Error: a row with too few or too many cells, a cell that is not a number.
  std::vector<double> read(const std::vector<std::size_t>& rows) const;

 private:
  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<double> times_;
};

}  // namespace momentree::io
