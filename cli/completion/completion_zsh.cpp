#include <cli/completion/completion.hpp>

namespace momentree::cli {

namespace {

// In single quotes, with the special characters of _arguments escaped.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'')
      out += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      out += std::string("\\") + c;
    else
      out += c;
  }
  return out;
}

std::string action_for(const Completed& what) {
  switch (what.what) {
    case Completed::What::sources: {
      std::string endings;
      for (const std::string& ending : source_endings()) endings += (endings.empty() ? "" : "|") + ending;
      return "_files -g \"*.(" + endings + ")(-.)\"";
    }
    case Completed::What::folders: return "_files -/";
    case Completed::What::states: return "_files -g \"*.json(-.)\"";
    case Completed::What::files: return "_files";
    case Completed::What::commands: return "_momentree_commands";
    case Completed::What::settings: return "_momentree_settings";
    case Completed::What::words: return "(" + spaced(what.words) + ")";
    default: return " ";
  }
}

// One specification for _arguments.
std::string specification(const OptionInfo& option) {
  const std::vector<std::string>& flags = option.flags;
  const bool again = option.repeatable && option.takes_value;
  std::string text = flags.size() > 1 && !again ? "'(" + spaced(flags) + ")'" : again ? "'*'" : "";
  if (flags.size() > 1) {
    text += "{";
    for (std::size_t i = 0; i < flags.size(); ++i) text += (i > 0 ? "," : "") + flags[i] + (option.takes_value ? "=" : "");
    text += "}";
  } else {
    text += flags.front() + (option.takes_value ? "=" : "");
  }
  text += "'[" + escaped(option.description) + "]";
  if (option.takes_value) text += ":" + escaped(option.type) + ":" + action_for(completed(option));
  return text + "'";
}

}  // namespace

std::string zsh_completion(const CommandTable& table) {
  std::string text = "#compdef momentree\n# zsh completion for momentree: `momentree completion zsh`\n\n";
  text += "_momentree_commands() {\n  local -a commands=(\n";
  for (const CommandInfo& command : table.commands) text += "    '" + command.name + ":" + escaped(command.description) + "'\n";
  text += "  )\n  _describe -t commands command commands\n}\n\n";
  text +=
      "_momentree_settings() {\n  if [[ $PREFIX == integrate.method=* ]]; then\n    compset -P 'integrate.method='\n    compadd "
      "-- " +
      spaced(method_names()) +
      "\n  elif [[ $PREFIX == integrate.variables=* ]]; then\n    compset -P 'integrate.variables='\n    compadd -- " +
      spaced(words_of_variables()) + "\n  else\n    compadd -S '' -- " + spaced(setting_keys()) + "\n  fi\n}\n\n";
  text += "_momentree() {\n  local context state state_descr line curcontext=$curcontext\n  typeset -A opt_args\n  _arguments -C";
  for (const OptionInfo& option : table.program.options) text += " \\\n    " + specification(option);
  text += " \\\n    '1:command:_momentree_commands' \\\n    '*::argument:->arguments' && return\n";
  text += "  [[ $state == arguments ]] || return\n  curcontext=${curcontext%:*:*}:momentree-$words[1]:\n  case $words[1] in\n";
  for (const CommandInfo& command : table.commands) {
    text += "    " + command.name + ")\n      _arguments";
    for (const OptionInfo& option : command.options) text += " \\\n        " + specification(option);
    for (const OptionInfo& argument : command.arguments) {
      text += std::string(" \\\n        '") + (argument.many ? "*" : "1") + ":" + escaped(argument.type) + ":" +
              action_for(completed(argument)) + "'";
    }
    text += " ;;\n";
  }
  text += "  esac\n}\n\n";
  // If autoloaded, the file is the function's body; if sourced, it registers the function.
  text += "if [[ $zsh_eval_context[-1] == loadautofunc ]]; then\n  _momentree \"$@\"\nelse\n  compdef _momentree momentree\nfi\n";
  return text;
}

}  // namespace momentree::cli
