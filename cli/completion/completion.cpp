#include <cli/completion/completion.hpp>

#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/models/import/model_file.hpp>
#include <momentree/scenario/keys/keys.hpp>

namespace momentree::cli {

std::string completion_script(const CommandTable& table, std::string_view shell) {
  if (shell == "bash") return bash_completion(table);
  if (shell == "zsh") return zsh_completion(table);
  if (shell == "fish") return fish_completion(table);
  const std::string name(shell);
  const std::string guess = did_you_mean(name, {"bash", "zsh", "fish"});
  throw Error{"there is no completion for '" + name + "'", "", guess.empty() ? "one of: bash, zsh, fish" : guess};
}

Completed completed(const OptionInfo& option) {
  using What = Completed::What;
  const std::string& type = option.type;
  const auto has = [&type](const char* word) { return type.find(word) != std::string::npos; };
  if (!option.takes_value) return {};
  if (has("SCENARIO") || (type == "FILE" && option.positional())) return {What::sources};
  if (has("DIR")) return {What::folders};
  if (has("STATE")) return {What::states};
  if (has("FILE")) return {What::files};
  if (has("COMMAND")) return {What::commands};
  if (has("KEY=VALUE")) return {What::settings};
  const bool small = std::ranges::all_of(type, [](char c) { return (c >= 'a' && c <= 'z') || c == '|'; });
  if (!small || !has("|")) return {};
  Completed choice{What::words};
  for (std::size_t begin = 0; begin <= type.size();) {
    const std::size_t end = std::min(type.find('|', begin), type.size());
    choice.words.push_back(type.substr(begin, end - begin));
    begin = end + 1;
  }
  return choice;
}

std::vector<std::string> source_endings() {
  std::vector<std::string> endings{"toml", "xml"};
  for (const std::string& ending : io::model_endings())
    if (std::ranges::count(endings, ending.substr(1)) == 0) endings.push_back(ending.substr(1));
  return endings;
}

std::vector<std::string> setting_keys() {
  std::vector<std::string> keys;
  const auto add = [&keys](const std::string& name, const io::KeyTable& table) {
    table.each([&](const io::Key& key) { keys.push_back(name + "." + key.name + "="); });
  };
  add("integrate", io::integrate_table);
  add("output", io::output_table);
  add("world", io::world_table);
  return keys;
}

std::vector<std::string> method_names() { return integration_methods(); }
std::vector<std::string> words_of_variables() { return variable_names(); }

std::string spaced(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

}  // namespace momentree::cli
