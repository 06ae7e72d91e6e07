#include <cli/text.hpp>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>

#include <momentree/base/characters.hpp>

namespace momentree::cli {

namespace {

constexpr std::string_view bold = "\x1b[1m", faint = "\x1b[2m", alarm = "\x1b[1;31m", usual = "\x1b[0m";

// Length of an escape sequence of Style at text[i], or 0.
std::size_t style_at(std::string_view text, std::size_t i) {
  for (const std::string_view code : {bold, faint, alarm, usual})
    if (text.substr(i).starts_with(code)) return code.size();
  return 0;
}

}  // namespace

void show(std::FILE* stream, std::string_view text) {
  const bool terminal = isatty(fileno(stream)) == 1;
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t kept = text[i] == '\n' ? 1 : terminal && text[i] == '\x1b' ? style_at(text, i) : 0;
    out += text.substr(i, kept);
    i += kept > 0 ? kept : append_printable(out, text, i);
  }
  std::fwrite(out.data(), 1, out.size(), stream);
}

std::string format(const char* pattern, ...) {
  std::va_list arguments, again;
  va_start(arguments, pattern);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, pattern, arguments);
  va_end(arguments);
  std::string text(static_cast<std::size_t>(std::max(length, 0)) + 1, '\0');
  std::vsnprintf(text.data(), text.size(), pattern, again);
  va_end(again);
  text.pop_back();
  return text;
}

std::size_t width(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string padded(std::string_view text, int columns) {
  const std::size_t wanted = static_cast<std::size_t>(std::abs(columns)), have = width(text);
  const std::string fill(wanted > have ? wanted - have : 0, ' ');
  return columns < 0 ? fill + std::string(text) : std::string(text) + fill;
}

std::string duration_text(double seconds) {
  const double size = std::fabs(seconds);
  if (size >= 100) return format("%.0f s", seconds);
  if (size >= 1) return format("%.3g s", seconds);
  if (size >= 1e-3) return format("%.3g ms", seconds * 1e3);
  if (size >= 1e-6) return format("%.3g µs", seconds * 1e6);
  return format("%.3g ns", seconds * 1e9);
}

std::string count_text(long count, const char* one, const char* many) { return format("%ld %s", count, count == 1 ? one : many); }

std::string Table::text(std::string_view indent) const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_)
    for (std::size_t c = 0; c < row.size(); ++c) {
      if (c == widths.size()) widths.push_back(0);
      widths[c] = std::max(widths[c], width(row[c]));
    }
  std::string text;
  for (const auto& row : rows_) {
    std::string line(indent);
    for (std::size_t c = 0; c < row.size(); ++c) {
      const int columns = static_cast<int>(widths[c]);
      line += c == 0 ? padded(row[c], columns) : "   " + padded(row[c], values_ == Values::right ? -columns : columns);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

Style Style::of_output() {
  const char* no_color = std::getenv("NO_COLOR");
  return Style(isatty(STDOUT_FILENO) == 1 && (no_color == nullptr || *no_color == '\0'));
}

std::string Style::heading(std::string_view text) const { return wrapped(bold, text); }
std::string Style::dim(std::string_view text) const { return wrapped(faint, text); }
std::string Style::bad(std::string_view text) const { return wrapped(alarm, text); }

std::string Style::wrapped(std::string_view code, std::string_view text) const {
  if (!colours_) return printable(text);
  return std::string(code) + printable(text) + std::string(usual);
}

}  // namespace momentree::cli
