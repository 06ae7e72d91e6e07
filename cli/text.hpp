#pragma once
// Text for a terminal: numbers with units, aligned columns, colours where they are wanted.
#include <string>
#include <string_view>
#include <vector>

namespace momentree::cli {

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

/// ANSI colours, or nothing at all.
class Style {
 public:
  explicit Style(bool colours) : colours_(colours) {}
  /// For standard output: colours on a terminal, unless NO_COLOR is set.
  static Style of_output();
  std::string heading(std::string_view text) const { return wrapped("1", text); }
  std::string dim(std::string_view text) const { return wrapped("2", text); }
  std::string bad(std::string_view text) const { return wrapped("1;31", text); }

 private:
  std::string wrapped(const char* code, std::string_view text) const;
  bool colours_;
};

}  // namespace momentree::cli
