#include <momentree/sweep/read_results.hpp>

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace momentree::sweep {

namespace {

// The cells of the next line, with quotes as in RFC 4180; false at the end, or if a quote is not closed.
bool next_line(std::string_view& text, std::vector<std::string>& cells) {
  cells.assign(1, "");
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') {
      if (quoted && i + 1 < text.size() && text[i + 1] == '"')
        cells.back() += text[++i];
      else
        quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else if (c == '\n' && !quoted) {
      text.remove_prefix(i + 1);
      return true;
    } else {
      cells.back() += c;
    }
  }
  return false;
}

std::optional<double> measure_of(const std::string& cell, bool is_flag) {
  if (cell.empty()) return NAN;
  if (is_flag) return cell == "true" ? std::optional(1.0) : cell == "false" ? std::optional(0.0) : std::nullopt;
  double x = 0;
  const std::from_chars_result read = std::from_chars(cell.data(), cell.data() + cell.size(), x);
  return read.ec == std::errc{} && read.ptr == cell.data() + cell.size() ? std::optional(x) : std::nullopt;
}

}  // namespace

bool read_csv(const Sweep& sweep, std::string_view text, const std::function<void(WorldResult)>& take) {
  std::string header;
  RowWriter(sweep).csv_header(header);
  if (!text.starts_with(header)) return false;
  text.remove_prefix(header.size());
  const std::size_t varied = parameter_columns(sweep).size(), measures = sweep.measures.size();
  std::vector<std::string> cells;
  constexpr std::string_view failed = "failed: ";
  for (std::uint64_t world = 0; world < sweep.worlds(); ++world) {
    if (!next_line(text, cells) || cells.size() != varied + measures + 2 || cells[0] != std::to_string(world)) return false;
    WorldResult result;
    const std::string& status = cells.back();
    if (status.starts_with(failed))
      result.failure = status.substr(failed.size());
    else if (status != "done")
      return false;
    for (std::size_t m = 0; m < measures; ++m) {
      const std::optional<double> x = measure_of(cells[1 + varied + m], sweep.measures[m].is_flag());
      if (!x) return false;
      result.measures.push_back(*x);
    }
    take(std::move(result));
  }
  return text.empty();
}

}  // namespace momentree::sweep
