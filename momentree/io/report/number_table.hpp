#pragma once
// A table of numbers with a time in its first column, as a run writes them. The file is read as a stream: it may be large.
#include <filesystem>
#include <string>
#include <vector>

namespace momentree::io {

class NumberTable {
 public:
  /// Reads the head and the times. A last line without its end is left out: an interrupted run was still writing it.
  /// Throws Error: a missing file, a first column that is not `time`, a time that is no number.
  explicit NumberTable(std::filesystem::path file);

  /// Without `time`.
  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<double>& times() const { return times_; }

  /// Of these rows (ascending) the numbers, one row after the other; NaN for an empty cell, infinity for one that is not
  /// finite. Throws Error: a row with too few or too many cells, a cell that is no number.
  std::vector<double> read(const std::vector<std::size_t>& rows) const;

 private:
  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<double> times_;
};

}  // namespace momentree::io
