#pragma once
// A user's mistake: what is wrong, where, and how to correct it. (For programming errors see MT_REQUIRE, base/check.hpp.)
#include <exception>
#include <string>
#include <string_view>
#include <vector>

namespace momentree {

/// Thrown at set-up (model, scenario, command line), never inside a step. `where` is empty or names a location: `file:line:col`,
/// a body or a joint.
class Error : public std::exception {
 public:
  Error(std::string the_problem, std::string the_place, std::string the_hint);
  std::string problem;
  std::string where;
  std::string hint;

  /// One line, `where: error: problem; hint`, safe for a terminal (see printable()).
  std::string message() const;
  /// The same line, as of the construction.
  const char* what() const noexcept override;

 protected:
  Error(std::string the_problem, std::string the_place, std::string the_hint, std::string the_line);

 private:
  std::string line_;
};

/// Throws `error`; in builds without exceptions (WebAssembly) it stops the program, so callers must validate first.
[[noreturn]] void throw_error(Error error);

/// The entry of `known` that `word` most likely means: equal apart from capitals, '_', '-' and spaces, or else the nearest within
/// an edit distance of a third of the word's length (at least 1). Empty if none is near.
std::string nearest(std::string_view word, const std::vector<std::string>& known);

/// "did you mean 'x'?" for the nearest entry, or empty.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known);

}  // namespace momentree
