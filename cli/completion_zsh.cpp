#include <cli/completion.hpp>

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
std::string specification(const CLI::Option& option) {
  const std::vector<std::string> flags = flags_of(option);
  const bool again = option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll && takes_value(option);
  std::string text = flags.size() > 1 && !again ? "'(" + spaced(flags) + ")'" : again ? "'*'" : "";
  if (flags.size() > 1) {
    text += "{";
    for (std::size_t i = 0; i < flags.size(); ++i) text += (i > 0 ? "," : "") + flags[i] + (takes_value(option) ? "=" : "");
    text += "}";
  } else {
    text += flags.front() + (takes_value(option) ? "=" : "");
  }
  text += "'[" + escaped(option.get_description()) + "]";
  if (takes_value(option)) text += ":" + escaped(option.get_type_name()) + ":" + action_for(completed(option));
  return text + "'";
}

}  // namespace

std::string zsh_completion(const CommandLine& line) {
  std::string text = "#compdef momentree\n# zsh completion for momentree: `momentree completion zsh`\n\n";
  text += "_momentree_commands() {\n  local -a commands=(\n";
  for (const CLI::App* sub : line.commands()) text += "    '" + sub->get_name() + ":" + escaped(sub->get_description()) + "'\n";
  text += "  )\n  _describe -t commands command commands\n}\n\n";
  text +=
      "_momentree_settings() {\n  if [[ $PREFIX == integrate.method=* ]]; then\n    compset -P 'integrate.method='\n    compadd "
      "-- " +
      spaced(method_names()) + "\n  else\n    compadd -S '' -- " + spaced(setting_keys()) + "\n  fi\n}\n\n";
  text += "_momentree() {\n  local context state state_descr line curcontext=$curcontext\n  typeset -A opt_args\n  _arguments -C";
  for (const CLI::Option* option : CommandLine::options_of(line.app())) text += " \\\n    " + specification(*option);
  text += " \\\n    '1:command:_momentree_commands' \\\n    '*::argument:->arguments' && return\n";
  text += "  [[ $state == arguments ]] || return\n  curcontext=${curcontext%:*:*}:momentree-$words[1]:\n  case $words[1] in\n";
  for (const CLI::App* sub : line.commands()) {
    text += "    " + sub->get_name() + ")\n      _arguments";
    for (const CLI::Option* option : CommandLine::options_of(*sub)) text += " \\\n        " + specification(*option);
    for (const CLI::Option* argument : CommandLine::arguments_of(*sub)) {
      const bool many = argument->get_items_expected_max() > 1;
      text += std::string(" \\\n        '") + (many ? "*" : "1") + ":" + escaped(argument->get_type_name()) + ":" +
              action_for(completed(*argument)) + "'";
    }
    text += " ;;\n";
  }
  text += "  esac\n}\n\n";
  // If autoloaded, the file is the function's body; if sourced, it registers the function.
  text += "if [[ $zsh_eval_context[-1] == loadautofunc ]]; then\n  _momentree \"$@\"\nelse\n  compdef _momentree momentree\nfi\n";
  return text;
}

}  // namespace momentree::cli
