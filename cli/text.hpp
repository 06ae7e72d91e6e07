#pragma once
// Text for a terminal: numbers with units, aligned columns, colours where they are wanted.
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace momentree::cli {

/// Writes text for people: whatever stands in it, nothing but line ends, tabs and the colours of Style commands a terminal. A
/// name of a file in it goes through printable() first, since it may have line ends of its own. Not for what programs read.
void show(std::FILE* stream, std::string_view text);

/// printf into a string.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

/// Columns that `text` takes on a terminal: code points of UTF-8.
std::size_t width(std::string_view text);
/// `text` filled with spaces to `columns`; a negative number aligns it to the right.
std::string padded(std::string_view text, int columns);

/// A duration with a unit that fits: "41.2 ms", "1.8 µs".
std::string duration_text(double seconds);
/// A count with a word: "1 body", "3 bodies".
std::string count_text(long count, const char* one, const char* many);

/// Rows of cells, as wide as they need; the first column is aligned to the left, the others as asked for.
class Table {
 public:
  enum class Values { right, left };
  explicit Table(Values values = Values::right) : values_(values) {}
  void row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  /// Each row on a line that begins with `indent`.
  std::string text(std::string_view indent) const;

 private:
  Values values_;
  std::vector<std::vector<std::string>> rows_;
};

/// ANSI colours around text as printable() shows it, or that text alone.
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
