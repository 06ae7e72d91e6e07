#pragma once
// A table of numbers with the time in its first column, as a run writes it. The file is read as a stream, since it may be larger
// than memory.
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace momentree::io {

class NumberTable {
 public:
  /// Reads the header and the times. A last line without a line end is left out: an interrupted run was still writing it.
  /// Throws Error: a missing or empty file, a first column that is not `time`, times that are not numbers or decrease.
  explicit NumberTable(std::filesystem::path file);

  /// Without `time`.
  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<double>& times() const { return times_; }

  /// The numbers of these rows (ascending), row by row; NaN for an empty cell. Throws Error: a row with too few or too many
  /// cells, a cell that is not a number.
  std::vector<double> read(const std::vector<std::size_t>& rows) const;
  /// Calls `visit` with each row in order, its time first. Throws Error as read() does.
  void each_row(const std::function<void(std::span<const double> row)>& visit) const;
  /// The row's place in the file, for messages: "bodies.csv:12".
  std::string place(std::size_t row) const { return at_line(lines_[row]); }
  /// The place of the header.
  std::string header_place() const { return at_line(1); }

 private:
  void append_cells(const std::string& line, const std::string& where, std::vector<double>& numbers) const;
  std::string at_line(std::size_t line) const { return file_.string() + ':' + std::to_string(line); }

  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<double> times_;
  std::vector<std::size_t> lines_;  // of the rows
};

/// The fields of one line of CSV (RFC 4180 quotes allowed).
std::vector<std::string> split_csv(const std::string& line);

}  // namespace momentree::io
