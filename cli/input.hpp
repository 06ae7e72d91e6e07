#pragma once
// What a command reads: files, or standard input under the name -.
#include <string>
#include <vector>

#include <momentree/io/scenario.hpp>

namespace momentree::cli {

/// How standard input is called in messages.
inline constexpr const char* standard_input = "<stdin>";
inline bool is_standard_input(const std::string& path) { return path == "-"; }

/// A scenario or a model. Throws Error where there is not enough memory. What standard input names is looked for in the current
/// folder; whether it is a model its text says.
io::ReadResult read_input(const std::string& path, const std::vector<std::string>& overrides = {});
/// The whole text of standard input. Throws Error where it is too large, or can't be read.
std::string read_standard_input();

/// Which notes on model files are printed: their number, in one line per file, or all of them.
enum class Notes { counted, listed };
/// Puts that line in the place of the notes on model files.
void count_notes(io::ReadResult& result);

}  // namespace momentree::cli
