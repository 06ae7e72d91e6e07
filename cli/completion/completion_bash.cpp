#include <cli/completion/completion.hpp>

namespace momentree::cli {

namespace {

// The bash function that fills COMPREPLY for this type of completion.
std::string call_for(const Completed& what) {
  switch (what.what) {
    case Completed::What::sources:
      return "_momentree_files '\\.(" + [] {
        std::string endings;
        for (const std::string& ending : source_endings()) endings += (endings.empty() ? "" : "|") + ending;
        return endings;
      }() + ")$'";
    case Completed::What::folders: return "_momentree_files '^$'";
    case Completed::What::states: return "_momentree_files '\\.json$'";
    case Completed::What::files: return "_momentree_files ''";
    case Completed::What::commands: return "_momentree_words \"$commands\"";
    case Completed::What::settings: return "_momentree_settings";
    case Completed::What::words: return "_momentree_words '" + spaced(what.words) + "'";
    default: return ":";
  }
}

constexpr const char* functions = R"(# Words that begin with what is typed.
_momentree_words() {
  local word
  for word in $1; do
    [[ $word == "$cur"* ]] && COMPREPLY+=("$prefix$word")
  done
}

# Folders, and files whose name matches; what is typed may be quoted in part.
_momentree_files() {
  local name typed=${cur//\\/}
  typed=${typed#[\"\']}
  compopt -o filenames 2>/dev/null
  while IFS= read -r name; do
    if [[ -d $name || $name =~ $1 ]]; then COMPREPLY+=("$prefix$name"); fi
  done < <(compgen -f -- "$typed")
}

_momentree_settings() {
  compopt -o nospace 2>/dev/null
  _momentree_words "$settings"
}
)";

}  // namespace

std::string bash_completion(const CommandTable& table) {
  std::vector<std::string> names;
  for (const CommandInfo& command : table.commands) names.push_back(command.name);
  std::string text = "# bash completion for momentree: `momentree completion bash`\n\n" + std::string(functions);
  text += R"(
_momentree() {
  local cur=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} prefix=
)";
  text += "  local commands='" + spaced(names) + "'\n  local settings='" + spaced(setting_keys()) + "'\n";
  text += R"(  COMPREPLY=()
  # '=' may stand within a word or be one of its own
  if [[ $cur == = ]]; then
    cur=
  elif [[ $before == = ]]; then
    before=${COMP_WORDS[COMP_CWORD-2]}
  elif [[ $cur == *=* ]]; then
    before=${cur%%=*} prefix=${cur%%=*}= cur=${cur#*=}
  fi
)";
  const std::pair<const char*, std::vector<std::string>> words[] = {{"method", method_names()},
                                                                    {"variables", words_of_variables()}};
  for (const auto& [key, all] : words)
    text += std::string("  if [[ $before == integrate.") + key + " ]]; then\n    _momentree_words '" + spaced(all) +
            "'\n    return\n  fi\n";
  text += "  if ((COMP_CWORD == 1)); then\n    if [[ $cur == -* ]]; then\n";
  std::vector<std::string> top;
  for (const OptionInfo& option : table.program.options) top.insert(top.end(), option.flags.begin(), option.flags.end());
  text +=
      "      _momentree_words '" + spaced(top) + "'\n    else\n      _momentree_words \"$commands\"\n    fi\n    return\n  fi\n";
  text += "  case ${COMP_WORDS[1]} in\n";
  for (const CommandInfo& command : table.commands) {
    std::vector<std::string> flags;
    std::string values;
    for (const OptionInfo& option : command.options) {
      std::string pattern;
      for (const std::string& flag : option.flags) {
        flags.push_back(flag);
        pattern += (pattern.empty() ? "" : " | ") + flag;
      }
      if (option.takes_value) values += "        " + pattern + ") " + call_for(completed(option)) + "; return ;;\n";
    }
    text += "    " + command.name + ")\n";
    if (!values.empty()) text += "      case $before in\n" + values + "      esac\n";
    text += "      if [[ $cur == -* && -z $prefix ]]; then\n        _momentree_words '" + spaced(flags) + "'\n";
    if (!command.arguments.empty()) text += "      else\n        " + call_for(completed(command.arguments.front())) + "\n";
    text += "      fi ;;\n";
  }
  text += "  esac\n}\n\ncomplete -F _momentree momentree\n";
  return text;
}

}  // namespace momentree::cli
