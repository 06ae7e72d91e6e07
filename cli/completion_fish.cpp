#include <cli/completion.hpp>

namespace momentree::cli {

namespace {

std::string quoted(const std::string& text) {
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
      return " -xa " + quoted(spaced(setting_keys()) + [] {
               std::string methods;
               for (const std::string& name : method_names()) methods += " integrate.method=" + name;
               return methods;
             }());
    case Completed::What::words: return " -xa " + quoted(spaced(what.words));
    default: return " -x";
  }
}

}  // namespace

std::string fish_completion(const CommandLine& line) {
  std::string names, suffixes;
  for (const CLI::App* sub : line.commands()) names += (names.empty() ? "" : " ") + sub->get_name();
  for (const std::string& ending : source_endings()) suffixes += " ." + ending;
  std::string text = "# fish completion for momentree: `momentree completion fish`\n\n";
  text += "function __momentree_sources\n  for suffix in" + suffixes + "\n    __fish_complete_suffix $suffix\n  end\nend\n\n";
  text += "function __momentree_commands\n  printf '%s\\n' " + names + "\nend\n\ncomplete -c momentree -f\n";
  const std::string first = " -n 'not __fish_seen_subcommand_from " + names + "'";
  for (const CLI::Option* option : CommandLine::options_of(line.app())) {
    text += "complete -c momentree" + first;
    for (const std::string& name : option->get_snames()) text += " -s " + name;
    for (const std::string& name : option->get_lnames()) text += " -l " + name;
    text += " -d " + quoted(option->get_description()) + "\n";
  }
  for (const CLI::App* sub : line.commands())
    text += "complete -c momentree" + first + " -a " + sub->get_name() + " -d " + quoted(sub->get_description()) + "\n";
  for (const CLI::App* sub : line.commands()) {
    const std::string seen = "complete -c momentree -n '__fish_seen_subcommand_from " + sub->get_name() + "'";
    for (const CLI::Option* option : CommandLine::options_of(*sub)) {
      text += seen;
      for (const std::string& name : option->get_snames()) text += " -s " + name;
      for (const std::string& name : option->get_lnames()) text += " -l " + name;
      if (takes_value(*option)) text += values(completed(*option));
      text += " -d " + quoted(option->get_description()) + "\n";
    }
    for (const CLI::Option* argument : CommandLine::arguments_of(*sub)) text += seen + values(completed(*argument)) + "\n";
  }
  return text;
}

}  // namespace momentree::cli
