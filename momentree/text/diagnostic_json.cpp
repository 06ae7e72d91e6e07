#include <momentree/text/diagnostic_json.hpp>

#include <algorithm>

#include <momentree/text/utf8.hpp>

namespace momentree::io {

namespace {

bool belongs_to_word(unsigned char c) {
  return c >= 0x80 || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-' ||
         c == '+' || c == '.';
}

// The byte after the token that begins at line[i]; i itself if the token is unknown, npos if it continues after the line.
std::size_t past(std::string_view line, std::size_t i) {
  constexpr std::size_t beyond = std::string_view::npos;
  const char c = line[i];
  if (c == '"' || c == '\'') {
    for (std::size_t k = i + 1; k < line.size(); ++k) {
      if (line[k] == '\\' && c == '"') {
        ++k;
      } else if (line[k] == c) {
        return k + 1;
      }
    }
    return beyond;
  }
  if (c == '[' || c == '{') {
    int depth = 0;
    for (std::size_t k = i; k < line.size();) {
      if (line[k] == '"' || line[k] == '\'') {
        k = past(line, k);
        if (k == beyond) return beyond;
        continue;
      }
      depth += line[k] == '[' || line[k] == '{';
      depth -= line[k] == ']' || line[k] == '}';
      ++k;
      if (depth == 0) return k;
    }
    return beyond;
  }
  std::size_t k = i + (c == '<' ? 1 : 0);
  while (k < line.size() && (belongs_to_word(static_cast<unsigned char>(line[k])) || (c == '<' && line[k] == ':'))) ++k;
  return k;
}

}  // namespace

int end_column(std::string_view line, int column) {
  std::size_t at = 0;
  for (int k = 1; k < column && at < line.size(); ++k) at += std::max<std::size_t>(character_length(line, at), 1);
  if (column < 1 || at >= line.size()) return 0;
  const std::size_t end = past(line, at);
  if (end == at || end == std::string_view::npos) return 0;
  int columns = column;
  for (; at < end && at < line.size(); ++columns) at += std::max<std::size_t>(character_length(line, at), 1);
  return columns;
}

void write_diagnostic(JsonWriter& json, const Diagnostic& d) {
  const auto number = [&json](const char* key, int n) {
    json.key(key);
    if (n > 0)
      json.value(n);
    else
      json.null();
  };
  const int end = d.line > 0 ? end_column(d.source, d.column) : 0;
  json.begin_object().member("severity", word_of(d.severity)).member("message", d.what).key("hint");
  if (d.hint.empty())
    json.null();
  else
    json.value(d.hint);
  json.member("file", d.file);
  number("line", d.line);
  number("column", d.line > 0 ? d.column : 0);
  number("end_line", end > 0 ? d.line : 0);
  number("end_column", end);
  json.end_object();
}

}  // namespace momentree::io
