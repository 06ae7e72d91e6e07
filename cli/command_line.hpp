#pragma once
// The table of commands and options, used for parsing, --help, the manual page and completion.
#include <CLI/CLI.hpp>

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <cli/commands.hpp>

namespace momentree::cli {

class CommandLine {
 public:
  CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// Parses and runs the command line. Throws Error if it is invalid.
  int call(int argc, char** argv);

  const CLI::App& app() const { return app_; }
  /// The available commands, in their order; commands that are not supported yet are left out.
  std::vector<const CLI::App*> commands() const;
  /// The help of a command, or of the program if no command has that name.
  std::string help(std::string_view command) const;

  /// The available options of a command, including --help; positional arguments.
  static std::vector<const CLI::Option*> options_of(const CLI::App& command);
  static std::vector<const CLI::Option*> arguments_of(const CLI::App& command);

 private:
  CLI::App* command(const char* name, const char* does, std::function<int()> action);
  void add_run();
  void add_readers();
  void add_writers();
  void add_pages();
  void add_helpers();
  void overrides(CLI::App* sub, std::vector<std::string>& values);
  void verbose(CLI::App* sub, bool& value);
  void served(CLI::App* sub, int& port, bool& no_browser);
  CLI::Option* source(CLI::App* sub, const char* name, std::string& value, const char* type, const char* does);
  // Names of the interface that are not implemented yet: parsed to give a clear error, hidden from help.
  void later(const char* name);
  void later(CLI::App* sub, const char* option, bool takes_value);

  const CLI::App* parsed() const;
  void require_known_arguments() const;
  void require_what_there_is() const;
  int print_help() const;

  CLI::App app_{"momentree: dynamics of mechanisms whose topology changes while they move", "momentree"};
  RunOptions run_;
  CheckOptions check_;
  EvaluateOptions evaluate_;
  ExplainOptions explain_;
  ConvertOptions convert_;
  CompileOptions compile_;
  ViewOptions view_;
  PlayOptions play_;
  BenchOptions bench_;
  std::string help_on_, shell_;
  std::vector<std::pair<CLI::App*, std::function<int()>>> actions_;
  std::vector<const CLI::App*> later_commands_;
  std::vector<std::pair<std::string, const CLI::Option*>> later_options_;
};

}  // namespace momentree::cli
