#pragma once
// A table of numbers with the time in its first column, as a run writes it. The file is read as a stream, since it may be larger
// than memory.
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/text/files/line_reader.hpp>

namespace momentree::io {

/// The fields of one line of CSV (RFC 4180 quotes allowed).
std::vector<std::string> split_csv(const std::string& line);

/// The number in a cell; NaN for an empty one. Throws Error with the column and the place.
double cell_number(std::string_view cell, std::string_view column, const std::string& where);

/// Reads a table whose first column is the time, row by row.
class RowReader {
 public:
  /// Reads the header. Throws Error: a missing or empty file, a first column that is not `time`.
  explicit RowReader(const std::filesystem::path& file);

  /// With `time`.
  const std::vector<std::string>& columns() const { return columns_; }
  /// Goes to the next row; false at the end. A last line without a line end is left out: an interrupted run was still writing it.
  /// Throws Error for times that are not finite or decrease.
  bool next();
  const std::string& line() const { return line_; }
  double time() const { return time_; }
  std::size_t number() const { return in_.number(); }  ///< of the line
  std::string place() const { return path_ + ':' + std::to_string(number()); }

 private:
  std::string path_, line_;
  LineReader in_;
  std::vector<std::string> columns_;
  double time_ = 0;
  bool begun_ = false;
};

class NumberTable {
 public:
  /// Reads the header and the times. Throws Error as RowReader does.
  explicit NumberTable(std::filesystem::path file);

  /// Without `time`.
  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<double>& times() const { return times_; }

  /// The numbers of these rows (ascending), row by row; NaN for an empty cell. Throws Error: a row with too few or too many
  /// cells, a cell that is not a number.
  std::vector<double> read(const std::vector<std::size_t>& rows) const;
  /// Those of all rows.
  std::vector<double> read() const;
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

/// A table that a result need not have; nothing if the file does not exist. Throws Error as NumberTable does.
std::optional<NumberTable> find_table(const std::filesystem::path& file);

}  // namespace momentree::io
