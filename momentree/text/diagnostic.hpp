#pragma once
// Diagnostics of input files in the format of a compiler: file:line:col: error: what; hint, then the source line and a caret.
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/base/value.hpp>

namespace momentree::io {

/// A note reports what was left out on purpose: the file is valid.
enum class Severity { error, warning, note };

/// One problem. `line` and `column` count from 1; 0 means that the problem has no position (a missing file, an option).
struct Diagnostic {
  Severity severity = Severity::error;
  std::string file;  ///< as the user named it; for an override `--set KEY=VALUE`
  int line = 0, column = 0;
  std::string what;
  std::string hint;    ///< how to fix it; may be empty
  std::string source;  ///< the text of the line; may be empty

  /// `file:line:col: error: what; hint`, on one line.
  std::string message() const;
  /// The same as an Error, for throwing it.
  Error error() const;
  /// The message, then the line of the file and a caret under the column.
  std::string rendered() const;
};

bool has_errors(const std::vector<Diagnostic>& diagnostics);
/// "error", "warning" or "note".
const char* word_of(Severity severity);
/// All diagnostics, rendered, each ending with a newline.
std::string rendered(const std::vector<Diagnostic>& diagnostics);

/// The errors of an input file. problem, where and hint are those of the first one; what() has all diagnostics, as the command
/// prints them.
class InputError : public Error {
 public:
  explicit InputError(std::vector<Diagnostic> all);
  std::vector<Diagnostic> diagnostics;

 private:
  InputError(Error first, std::vector<Diagnostic>&& all);
};

/// Collects the problems of one file. Places are resolved to lines. The number of diagnostics of each severity is bounded, and
/// more than three that differ only in their place are one with their count.
class Diagnostics {
 public:
  /// `options`: the overrides from the command line, for places that refer to them. `text` must outlive this object; if it is
  /// empty, no source lines are shown.
  Diagnostics(std::string file, std::string_view text, std::vector<std::string> options = {});

  void error(Place place, std::string what, std::string hint = {}) {
    add(Severity::error, place, std::move(what), std::move(hint));
  }
  void warning(Place place, std::string what, std::string hint = {}) {
    add(Severity::warning, place, std::move(what), std::move(hint));
  }
  void note(Place place, std::string what, std::string hint = {}) {
    add(Severity::note, place, std::move(what), std::move(hint));
  }
  std::size_t errors() const { return errors_; }
  /// Throws the first error as an Error if there is any.
  void throw_first();
  /// The limit on errors is reached: a reader may stop.
  bool full() const { return kept_[0] >= most; }
  /// `line 12`, or the option, to name a second place in a message.
  std::string name_of(Place place) const;
  /// The diagnostics in the order of the file.
  std::vector<Diagnostic> take();

 private:
  static constexpr std::size_t most = 100, most_equal = 3;
  void add(Severity severity, Place place, std::string what, std::string hint);
  std::string_view line_text(int line);

  std::string file_;
  std::string_view text_;
  std::vector<std::string> options_;
  std::vector<std::size_t> line_starts_;
  std::vector<Diagnostic> diagnostics_;
  std::vector<Place> places_;
  /// Of those that are equal but for their place: how many there are, and the first and the last place.
  struct Equal {
    std::size_t count = 1;
    Place first{}, last{};
  };
  void unite_equal();
  std::vector<Equal> equal_;
  std::size_t errors_ = 0, kept_[3] = {}, dropped_[3] = {};  ///< by severity
};

/// `name` in quotes, shortened if it is long and made printable with printable(), for use in a message.
std::string in_quotes(std::string_view name);

/// Checks bare names of bodies and joints: names that a path, a column or a wildcard cannot contain are errors.
bool check_bare_name(const std::string& name, Place place, std::string_view what, Diagnostics& out);

}  // namespace momentree::io
