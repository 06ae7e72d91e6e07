#include <momentree/scenario/known_scenario.hpp>

#include <algorithm>

namespace momentree::io {

namespace {

std::string_view without_blanks(std::string_view text) {
  return text.substr(std::min(text.find_first_not_of(" \t"), text.size()));
}

// `format = 1`, `[[mechanism]]`, `[mechanism.chain]` or `mechanism = …`
bool is_line_of_scenario(std::string_view line) {
  if (line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
  line = without_blanks(line);
  const bool header = line.starts_with('[');
  line = without_blanks(line.substr(std::min(line.find_first_not_of('['), line.size())));
  const bool format = line.starts_with("format") && !header;
  if (!format && !line.starts_with("mechanism")) return false;
  line = without_blanks(line.substr(format ? 6 : 9));
  if (!format) return line.starts_with(header ? ']' : '=') || line.starts_with('.');
  line = without_blanks(line.substr(line.starts_with('=') ? 1 : 0));
  if (line.starts_with('"') || line.starts_with('\'')) line.remove_prefix(1);
  return !line.empty() && line[0] >= '0' && line[0] <= '9';
}

}  // namespace

bool is_known_scenario(std::string_view text) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    if (is_line_of_scenario(line)) return true;
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
  return false;
}

}  // namespace momentree::io
