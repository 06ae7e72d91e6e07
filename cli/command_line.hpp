#pragma once
// The table of commands and options, used for parsing, --help, the manual page and completion.
#include <string>
#include <string_view>
#include <vector>

#include <cli/commands.hpp>

namespace momentree::cli {

/// An option, or a positional argument.
struct OptionInfo {
  std::vector<std::string> flags;  ///< "-s" and "--long"; empty for an argument
  std::string type, description;
  bool takes_value = false, many = false, required = false, repeatable = false;

  bool positional() const { return flags.empty(); }
};
struct CommandInfo {
  std::string name, description;
  std::vector<OptionInfo> options, arguments;
};
struct CommandTable {
  CommandInfo program;  ///< its options, without a command
  std::vector<CommandInfo> commands;
};

/// Parses and runs the command line; `bench`: that command; `commit`: what --version says. Throws Error if it is invalid.
int call(int argc, char** argv, Bench bench, std::string_view commit);

}  // namespace momentree::cli
