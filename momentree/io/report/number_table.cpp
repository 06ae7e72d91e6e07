#include <momentree/io/report/number_table.hpp>

#include <charconv>
#include <cmath>
#include <string_view>

#include <momentree/base/error.hpp>
#include <momentree/io/line_reader.hpp>
#include <momentree/io/picture/body_table.hpp>

namespace momentree::io {

namespace {

std::string place(const std::filesystem::path& file, std::size_t line) { return file.string() + ":" + std::to_string(line); }

double number(std::string_view cell, const std::string& where) {
  if (cell.empty()) return std::nan("");
  double value = 0;
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  if (error != std::errc{} || stop != end)
    throw_error({"'" + std::string(cell) + "' is not a number", where, "the file was truncated or modified: run again"});
  return std::isfinite(value) ? value : HUGE_VAL;
}

}  // namespace

NumberTable::NumberTable(std::filesystem::path file) : file_(std::move(file)) {
  if (!is_there(file_)) throw_error({"there is no such file", file_.string(), "give the directory that `momentree run` wrote"});
  LineReader in(file_);
  std::string line;
  in.next(line);
  columns_ = split_csv(line);
  if (columns_.front() != "time")
    throw_error({"the first column is '" + columns_.front() + "', not 'time'", place(file_, 1), {}});
  columns_.erase(columns_.begin());
  while (in.next(line) && in.is_whole())
    times_.push_back(number(std::string_view(line).substr(0, line.find(',')), place(file_, in.number())));
}

std::vector<double> NumberTable::read(const std::vector<std::size_t>& rows) const {
  std::vector<double> numbers;
  numbers.reserve(rows.size() * columns_.size());
  LineReader in(file_);
  std::string line;
  in.next(line);
  std::size_t next = 0;
  for (const std::size_t wanted : rows) {
    for (; next <= wanted; ++next) in.next(line);
    const std::string where = place(file_, wanted + 2);
    std::size_t cells = 0;
    for (std::size_t at = line.find(','); at != std::string::npos; ++cells) {
      const std::size_t end = line.find(',', at + 1);
      numbers.push_back(number(std::string_view(line).substr(at + 1, end == std::string::npos ? end : end - at - 1), where));
      at = end;
    }
    if (cells != columns_.size())
      throw_error({"the row has " + std::to_string(cells + 1) + " of " + std::to_string(columns_.size() + 1) + " columns", where,
                   "the file was truncated or modified: run again"});
  }
  return numbers;
}

}  // namespace momentree::io
