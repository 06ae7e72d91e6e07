#include <cli/completion/completion.hpp>

namespace momentree::cli {

namespace {

std::string fish_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + "'";
}

// The offered values, as arguments of `complete`.
std::string values(const Completed& what) {
  switch (what.what) {
    case Completed::What::sources: return " -k -xa '(__momentree_sources)'";
    case Completed::What::folders: return " -xa '(__fish_complete_directories (commandline -ct))'";
    case Completed::What::states: return " -k -xa '(__fish_complete_suffix .json)'";
    case Completed::What::files: return " -rF";
    case Completed::What::commands: return " -xa '(__momentree_commands)'";
    case Completed::What::settings:
      return " -xa " + fish_quoted(spaced(setting_keys()) + [] {
               std::string methods;
               for (const std::string& name : method_names()) methods += " integrate.method=" + name;
               for (const std::string& name : words_of_variables()) methods += " integrate.variables=" + name;
               return methods;
             }());
    case Completed::What::words: return " -xa " + fish_quoted(spaced(what.words));
    default: return " -x";
  }
}

std::string flags(const OptionInfo& option) {
  std::string text;
  for (const std::string& flag : option.flags) text += flag.starts_with("--") ? " -l " + flag.substr(2) : " -s " + flag.substr(1);
  return text;
}

}  // namespace

std::string fish_completion(const CommandTable& table) {
  std::string names, suffixes;
  for (const CommandInfo& command : table.commands) names += (names.empty() ? "" : " ") + command.name;
  for (const std::string& ending : source_endings()) suffixes += " ." + ending;
  std::string text = "# fish completion for momentree: `momentree completion fish`\n\n";
  text += "function __momentree_sources\n  for suffix in" + suffixes + "\n    __fish_complete_suffix $suffix\n  end\nend\n\n";
  text += "function __momentree_commands\n  printf '%s\\n' " + names + "\nend\n\ncomplete -c momentree -f\n";
  const std::string first = " -n 'not __fish_seen_subcommand_from " + names + "'";
  for (const OptionInfo& option : table.program.options)
    text += "complete -c momentree" + first + flags(option) + " -d " + fish_quoted(option.description) + "\n";
  for (const CommandInfo& command : table.commands)
    text += "complete -c momentree" + first + " -a " + command.name + " -d " + fish_quoted(command.description) + "\n";
  for (const CommandInfo& command : table.commands) {
    const std::string seen = "complete -c momentree -n '__fish_seen_subcommand_from " + command.name + "'";
    for (const OptionInfo& option : command.options)
      text += seen + flags(option) + (option.takes_value ? values(completed(option)) : "") + " -d " +
              fish_quoted(option.description) + "\n";
    for (const OptionInfo& argument : command.arguments) text += seen + values(completed(argument)) + "\n";
  }
  return text;
}

}  // namespace momentree::cli
