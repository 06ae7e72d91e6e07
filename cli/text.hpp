#pragma once
// Terminal text: numbers with units, aligned columns, optional colours.
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace momentree::cli {

/// Writes text for people. Of control characters, only line ends, tabs and the colours of Style reach the terminal. File names
/// in the text must go through printable() first, since they may contain line ends. Not for machine-readable output.
void show(std::FILE* stream, std::string_view text);

/// printf into a string.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

/// The number of terminal columns of `text`: its UTF-8 code points.
std::size_t width(std::string_view text);
/// `text` padded with spaces to `columns`; a negative number aligns it to the right.
std::string padded(std::string_view text, int columns);

/// A duration with a suitable unit: "41.2 ms", "1.8 µs".
std::string duration_text(double seconds);
/// A count with its noun: "1 body", "3 bodies".
std::string count_text(long count, const char* one, const char* many);

/// Rows of cells with columns as wide as needed; the first column is left-aligned, the others as requested.
class Table {
 public:
  enum class Values { right, left };
  explicit Table(Values values = Values::right) : values_(values) {}
  void row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  /// Each row on its own line, which begins with `indent`.
  std::string text(std::string_view indent) const;

 private:
  Values values_;
  std::vector<std::vector<std::string>> rows_;
};

/// ANSI colours around text that went through printable(), or the text alone.
class Style {
 public:
  explicit Style(bool colours) : colours_(colours) {}
  /// For standard output: colours on a terminal, unless NO_COLOR is set.
  static Style of_output();
  std::string heading(std::string_view text) const;
  std::string dim(std::string_view text) const;
  std::string bad(std::string_view text) const;

 private:
  std::string wrapped(std::string_view code, std::string_view text) const;
  bool colours_;
};

}  // namespace momentree::cli
