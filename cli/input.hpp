#pragma once
// The input of a command: files, or standard input under the name -.
#include <string>
#include <vector>

#include <momentree/io/scenario.hpp>

namespace momentree::cli {

/// The name of standard input in messages.
inline constexpr const char* standard_input = "<stdin>";
inline bool is_standard_input(const std::string& path) { return path == "-"; }

/// Reads a scenario or a model. Throws Error if there is not enough memory. Files named in standard input are located in the
/// current folder; its text determines whether it is a model.
io::ReadResult read_input(const std::string& path, const std::vector<std::string>& overrides = {});
/// The whole text of standard input. Throws Error if it is too large, or cannot be read.
std::string read_standard_input();

/// How notes on model files are printed: their number, in one line per file, or all of them.
enum class Notes { counted, listed };
/// Replaces the notes on model files by one line with their number.
void count_notes(io::ReadResult& result);

}  // namespace momentree::cli
