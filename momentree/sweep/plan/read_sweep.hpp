#pragma once
// Reads sweep files (TOML).
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/sweep/sweep.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::sweep {

struct ReadSweep {
  std::optional<Sweep> sweep;                 ///< absent if there is an error
  std::vector<io::Diagnostic> diagnostics{};  ///< errors and warnings, in the order of the file
};

/// Reads and checks a sweep file and its scenario: every parameter is tried at the ends and in the middle of its values, and
/// every measure must exist. Every problem is a diagnostic; nothing is thrown.
ReadSweep read_sweep(const std::string& path);
/// The same from a text. `path` names it in messages and locates the scenario.
ReadSweep read_sweep_text(std::string text, const std::string& path);

/// Whether the text is a sweep rather than a scenario: it names a scenario or has a table [vary].
bool is_sweep(std::string_view text);

}  // namespace momentree::sweep
