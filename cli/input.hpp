#pragma once
// The input of a command: files, or standard input under the name -.
#include <memory>
#include <string>
#include <vector>

#include <momentree/results/session.hpp>

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

/// Reads a scenario or a model, from standard input if the path is "-". Prints diagnostics of severity `least` or worse to
/// standard error; of notes on model files only the number, unless they are to be `listed`. Null if there are errors.
std::shared_ptr<const io::Scenario> load(const std::string& path, const std::vector<std::string>& overrides,
                                         Notes notes = Notes::counted, io::Severity least = io::Severity::note);
inline Notes notes_of(bool verbose) { return verbose ? Notes::listed : Notes::counted; }

/// Throws Error if the output file is the scenario, or a model or state document that it names. "-" is standard output.
void refuse_to_overwrite(const std::string& out, const io::Scenario& scenario);

/// The documents for a Session: that of `state`, "-" for standard input; empty: none.
std::vector<io::RestoredState> documents_of(const std::string& state, const Model& model);

}  // namespace momentree::cli
