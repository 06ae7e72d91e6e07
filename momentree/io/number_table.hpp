#pragma once
// A CSV table of numbers with the time in its first column, as a run writes it. The file is read as a stream, since it may be
// larger than memory.
#include <filesystem>
#include <string>
#include <vector>

namespace momentree::io {

class NumberTable {
 public:
  /// Reads the header and the times. A last line without a line end is left out: an interrupted run was still writing it.
  /// Throws Error: a missing or empty file, a first column that is not `time`, times that are not numbers or run backwards.
  explicit NumberTable(std::filesystem::path file);

  /// Without `time`.
  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<double>& times() const { return times_; }

  enum class Gaps { allowed, refused };
  /// The numbers of these rows (ascending), row by row; NaN for an empty cell, infinity for a value that is not finite, unless
  /// these are refused. Throws Error: a row with too few or too many cells, a cell that is not a number.
  std::vector<double> read(const std::vector<std::size_t>& rows, Gaps gaps) const;
  /// `file:line` of a row; of the header without one.
  std::string place(std::size_t row) const;
  std::string place() const { return file_.string() + ":1"; }

 private:
  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<double> times_;
  std::vector<std::size_t> lines_;  // by row
};

/// The fields of one line of CSV (RFC 4180 quotes allowed).
std::vector<std::string> split_csv(const std::string& line);

}  // namespace momentree::io
