#include <momentree/io/number_table.hpp>

#include <charconv>
#include <cmath>
#include <string_view>

#include <momentree/base/error.hpp>
#include <momentree/io/line_reader.hpp>

namespace momentree::io {

namespace {

double number(std::string_view cell, const std::string& column, const std::string& where, NumberTable::Gaps gaps) {
  const bool allowed = gaps == NumberTable::Gaps::allowed;
  if (cell.empty() && allowed) return std::nan("");
  double value = 0;
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  if (error != std::errc{} || stop != end)
    throw_error({"column '" + column + "': '" + std::string(cell) + "' is not a number", where,
                 "the file was truncated or modified: run again"});
  if (std::isfinite(value)) return value;
  if (!allowed)
    throw_error({"column '" + column + "' is " + std::string(cell) + ", not a finite number", where,
                 "the run diverged here; try a smaller step"});
  return HUGE_VAL;
}

}  // namespace

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

NumberTable::NumberTable(std::filesystem::path file) : file_(std::move(file)) {
  if (!is_there(file_)) throw_error({"there is no such file", file_.string(), "give the directory that `momentree run` wrote"});
  LineReader in(file_);
  std::string line;
  if (!in.next(line)) throw_error({"the file is empty", file_.string(), {}});
  columns_ = split_csv(line);
  if (columns_.front() != "time") throw_error({"the first column is '" + columns_.front() + "', not 'time'", place(), {}});
  columns_.erase(columns_.begin());
  while (in.next(line) && in.is_whole()) {
    if (line.empty()) continue;
    lines_.push_back(in.number());
    const std::string_view cell = std::string_view(line).substr(0, line.find(','));
    times_.push_back(number(cell, "time", place(times_.size()), Gaps::refused));
    if (times_.size() > 1 && times_.back() < times_[times_.size() - 2])
      throw_error({"time runs backwards", place(times_.size() - 1), {}});
  }
}

std::string NumberTable::place(std::size_t row) const { return file_.string() + ":" + std::to_string(lines_[row]); }

std::vector<double> NumberTable::read(const std::vector<std::size_t>& rows, Gaps gaps) const {
  std::vector<double> numbers;
  numbers.reserve(rows.size() * columns_.size());
  LineReader in(file_);
  std::string line;
  for (const std::size_t wanted : rows) {
    while (in.number() < lines_[wanted] && in.next(line)) {
    }
    std::size_t cells = 0;
    for (std::size_t at = line.find(','); at != std::string::npos; ++cells) {
      const std::size_t end = line.find(',', at + 1);
      const std::string_view cell = std::string_view(line).substr(at + 1, end == std::string::npos ? end : end - at - 1);
      if (cells < columns_.size()) numbers.push_back(number(cell, columns_[cells], place(wanted), gaps));
      at = end;
    }
    if (cells != columns_.size())
      throw_error({"the row has " + std::to_string(cells + 1) + " of " + std::to_string(columns_.size() + 1) + " columns",
                   place(wanted), "the file was truncated or modified: run again"});
  }
  return numbers;
}

}  // namespace momentree::io
