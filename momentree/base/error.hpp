#pragma once
// A user's mistake: what is wrong, where it stands, how to mend it. (Our own mistakes are MT_REQUIRE, base/check.hpp.)
#include <string>
#include <string_view>
#include <vector>

namespace momentree {

/// Thrown at set-up (model, scenario, command line), never inside a step.
/// `where` is empty or names a place: `file:line:col`, or a body or joint.
struct Error {
  std::string what;
  std::string where;
  std::string hint;

  /// One line: `where: error: what; hint`, fit for a terminal (see printable()).
  std::string message() const;
};

/// Throws `error`; without exceptions (WebAssembly) it stops the program: validate first there.
[[noreturn]] void throw_error(Error error);

/// The entry of `known` that `word` most likely meant: the same but for capitals, '_', '-' and spaces, or else within an edit
/// distance of a third of its length (at least 1). Empty if none is near.
std::string nearest(std::string_view word, const std::vector<std::string>& known);

/// "did you mean 'x'?" for the nearest entry, or empty.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known);

}  // namespace momentree
