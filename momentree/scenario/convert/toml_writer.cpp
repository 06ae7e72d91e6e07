#include <momentree/scenario/convert/toml_writer.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>

#include <momentree/base/characters.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

constexpr std::size_t widest = 110;  // longer lists of lists get one line per entry

std::string toml_string(std::string_view text) {
  std::string out = "\"";
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text, i);
    const char32_t c = length == 0 ? U'\ufffd' : code_point(text.substr(i, length));
    if (c == '"' || c == '\\') {
      out += '\\', out += text[i];
    } else if (c == '\n') {
      out += "\\n";
    } else if (c == '\t') {
      out += "\\t";
    } else if (is_visible(c) && length > 0) {
      out += text.substr(i, length);
    } else {
      out += c < 0x10000 ? "\\u" : "\\U";
      for (int shift = c < 0x10000 ? 12 : 28; shift >= 0; shift -= 4) out += "0123456789abcdef"[c >> shift & 15];
    }
    i += std::max<std::size_t>(length, 1);
  }
  return out + '"';
}

std::string key_text(const std::string& key) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !key.empty() && std::all_of(key.begin(), key.end(), plain) ? key : toml_string(key);
}

std::string real_text(double x) {
  std::string text;
  if (std::fabs(x) < 1e6 && x == std::floor(x)) {
    append_number(text, static_cast<long>(x));
    return text;
  }
  append_number(text, x);
  if (std::isfinite(x) && text.find_first_of(".e") == std::string::npos) text += ".0";  // it may be too large for an integer
  return text;
}

// `indent`: of the line with the value, for lists that span several lines.
std::string value_text(const Value& value, const std::string& indent);

std::string list_text(const Value::Array& entries, const std::string& indent) {
  std::string line;
  bool nested = false;
  for (const Value& entry : entries) {
    nested = nested || entry.array() || entry.table();
    line += (line.empty() ? "" : ", ") + value_text(entry, indent);
  }
  if (!nested || line.size() <= widest) return "[" + line + "]";
  std::string text = "[\n";
  for (const Value& entry : entries) text += indent + "  " + value_text(entry, indent + "  ") + ",\n";
  return text + indent + "]";
}

std::string table_text(const Value::Table& entries, const std::string& indent) {
  std::string line;
  for (const Value::Entry& entry : entries)
    if (entry.key != comment_key)
      line += (line.empty() ? "" : ", ") + key_text(entry.key) + " = " + value_text(entry.value, indent);
  return line.empty() ? "{}" : "{ " + line + " }";
}

std::string value_text(const Value& value, const std::string& indent) {
  if (const bool* b = value.boolean()) return *b ? "true" : "false";
  if (const std::int64_t* n = value.integer()) return std::to_string(*n);
  if (const double* x = value.real()) return real_text(*x);
  if (const std::string* text = value.string()) return toml_string(*text);
  if (const Value::Array* entries = value.array()) return list_text(*entries, indent);
  if (const Value::Table* entries = value.table()) return table_text(*entries, indent);
  return "\"\"";
}

// Whether a key gets a header, by the path of the table that contains it.
bool has_header(std::string_view path, const Value::Entry& entry) {
  const auto is = [&](std::initializer_list<std::string_view> keys) {
    return std::find(keys.begin(), keys.end(), entry.key) != keys.end();
  };
  if (entry.value.is_array_of_tables())
    return path.empty() ? is({"mechanism", "force", "loop", "coupling", "event"}) : path == "mechanism" && is({"body"});
  if (!entry.value.table()) return false;
  if (path.empty()) return is({"world", "integrate", "output"});
  return path == "mechanism" ? is({"chain"}) : path == "mechanism.body" && is({"joint"});
}

void write_table(std::string& text, const Value::Table& table, const std::string& path) {
  std::size_t width = 0;
  for (const Value::Entry& entry : table)
    if (entry.key != comment_key && !has_header(path, entry)) width = std::max(width, key_text(entry.key).size());
  for (const Value::Entry& entry : table) {
    if (entry.key == comment_key || has_header(path, entry)) continue;
    const std::string key = key_text(entry.key);
    text += key + std::string(width - key.size(), ' ') + " = " + value_text(entry.value, "") + "\n";
  }
  const auto section = [&](const Value::Table& inner, const std::string& inner_path, const std::string& header) {
    if (!text.empty() && inner_path != "mechanism.body.joint") text += "\n";
    for (const Value::Entry& entry : inner)
      if (entry.key == comment_key && entry.value.string()) text += "# " + *entry.value.string() + "\n";
    text += header + "\n";
    write_table(text, inner, inner_path);
  };
  for (const Value::Entry& entry : table) {
    if (entry.key == comment_key || !has_header(path, entry)) continue;
    const std::string inner = (path.empty() ? "" : path + ".") + entry.key;
    if (const Value::Table* one = entry.value.table())
      section(*one, inner, "[" + inner + "]");
    else
      for (const Value& each : *entry.value.array()) section(*each.table(), inner, "[[" + inner + "]]");
  }
}

}  // namespace

std::string toml_value_text(const Value& value) { return value_text(value, ""); }

std::string toml_text(const Value& document) {
  std::string text;
  if (const Value::Table* table = document.table()) write_table(text, *table, "");
  return text;
}

}  // namespace momentree::io
