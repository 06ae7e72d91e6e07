#include <momentree/results/recording/number_table.hpp>

#include <charconv>
#include <cmath>
#include <string_view>

#include <momentree/base/error.hpp>

namespace momentree::io {

namespace {

constexpr const char* damaged_table = "the file was truncated or modified: run again";

const std::filesystem::path& required_table(const std::filesystem::path& file) {
  if (!is_there(file) && is_there(file.parent_path() / "results.h5"))
    throw_error({"the tables of this result are in results.h5, and only CSV tables can be shown", file.parent_path().string(),
                 "run again with --format csv, or with --report"});
  if (!is_there(file)) throw_error({"there is no such file", file.string(), "give the directory that `momentree run` wrote"});
  return file;
}

}  // namespace

double cell_number(std::string_view cell, std::string_view column, const std::string& where) {
  if (cell.empty()) return std::nan("");
  double value = 0;
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  if (error != std::errc{} || stop != end)
    throw_error({"column '" + std::string(column) + "': '" + std::string(cell) + "' is not a number", where, damaged_table});
  return value;
}

std::vector<std::string> split_csv(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      fields.back() += line[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

RowReader::RowReader(const std::filesystem::path& file) : path_(file.string()), in_(required_table(file)) {
  if (!in_.next(line_)) throw_error({"the file is empty", path_, {}});
  columns_ = split_csv(line_);
  if (columns_.front() != "time") throw_error({"the first column is '" + columns_.front() + "', not 'time'", place(), {}});
}

bool RowReader::next() {
  do
    if (!in_.next(line_) || !in_.is_whole()) return false;
  while (line_.empty());
  const double time = cell_number(std::string_view(line_).substr(0, line_.find(',')), "time", place());
  if (!std::isfinite(time)) throw_error({"the time is not a finite number", place(), damaged_table});
  if (begun_ && time < time_) throw_error({"time runs backwards", place(), {}});
  time_ = time, begun_ = true;
  return true;
}

NumberTable::NumberTable(std::filesystem::path file) : file_(std::move(file)) {
  RowReader in(file_);
  columns_.assign(in.columns().begin() + 1, in.columns().end());
  while (in.next()) times_.push_back(in.time()), lines_.push_back(in.number());
}

void NumberTable::append_cells(const std::string& line, const std::string& where, std::vector<double>& numbers) const {
  std::size_t cells = 0;
  for (std::size_t at = line.find(','); at != std::string::npos; ++cells) {
    const std::size_t end = line.find(',', at + 1);
    const std::string_view cell = std::string_view(line).substr(at + 1, end == std::string::npos ? end : end - at - 1);
    if (cells < columns_.size()) numbers.push_back(cell_number(cell, columns_[cells], where));
    at = end;
  }
  if (cells != columns_.size())
    throw_error({"the row has " + std::to_string(cells + 1) + " of " + std::to_string(columns_.size() + 1) + " columns", where,
                 damaged_table});
}

std::vector<double> NumberTable::read(const std::vector<std::size_t>& rows) const {
  std::vector<double> numbers;
  numbers.reserve(rows.size() * columns_.size());
  LineReader in(file_);
  std::string line;
  for (const std::size_t row : rows) {
    while (in.number() < lines_[row] && in.next(line)) {
    }
    append_cells(line, place(row), numbers);
  }
  return numbers;
}

std::vector<double> NumberTable::read() const {
  std::vector<double> numbers;
  numbers.reserve(times_.size() * columns_.size());
  each_row([&](std::span<const double> row) { numbers.insert(numbers.end(), row.begin() + 1, row.end()); });
  return numbers;
}

void NumberTable::each_row(const std::function<void(std::span<const double> row)>& visit) const {
  LineReader in(file_);
  std::string line;
  std::vector<double> row;
  for (std::size_t i = 0; i < times_.size(); ++i) {
    while (in.number() < lines_[i] && in.next(line)) {
    }
    row.assign(1, times_[i]);
    append_cells(line, place(i), row);
    visit(row);
  }
}

std::optional<NumberTable> find_table(const std::filesystem::path& file) {
  return is_there(file) ? std::optional<NumberTable>(file) : std::nullopt;
}

}  // namespace momentree::io
