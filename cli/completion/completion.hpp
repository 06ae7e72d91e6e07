#pragma once
// Scripts that complete command lines in bash, zsh and fish, from the table of commands and options.
#include <string>
#include <string_view>
#include <vector>

#include <cli/command_line.hpp>

namespace momentree::cli {

/// The script for "bash", "zsh" or "fish"; throws Error for any other shell.
std::string completion_script(const CommandTable& table, std::string_view shell);

/// The possible values of an argument or an option.
struct Completed {
  enum class What { nothing, sources, folders, states, files, commands, settings, words };
  What what = What::nothing;
  std::vector<std::string> words{};  ///< of What::words
};
Completed completed(const OptionInfo& option);

/// Endings of scenario and model files, without the dot.
std::vector<std::string> source_endings();
/// Common keys for --set, each with its '=', and those of their values that are words.
std::vector<std::string> setting_keys();
std::vector<std::string> method_names();
std::vector<std::string> words_of_variables();

std::string bash_completion(const CommandTable& table);
std::string zsh_completion(const CommandTable& table);
std::string fish_completion(const CommandTable& table);

/// "A B C"
std::string spaced(const std::vector<std::string>& words);

}  // namespace momentree::cli
