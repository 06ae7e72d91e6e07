#include <momentree/text/json_writer.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/base/characters.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

// \uXXXX; two of them (surrogates) beyond the first plane.
void append_escape(std::string& text, char32_t c) {
  const auto append = [&text](char32_t unit) {
    text += "\\u";
    for (int shift = 12; shift >= 0; shift -= 4) text += "0123456789abcdef"[unit >> shift & 15];
  };
  if (c < 0x10000) return append(c);
  append(0xd800 + ((c - 0x10000) >> 10));
  append(0xdc00 + ((c - 0x10000) & 0x3ff));
}

}  // namespace

void JsonWriter::line() {
  text_ += '\n';
  text_.append(static_cast<std::size_t>(2 * level_), ' ');
}

void JsonWriter::before_item() {
  if (after_key_) {
    after_key_ = false;
    return;
  }
  if (!first_) text_ += level_ <= depth_ ? "," : ", ";
  first_ = false;
  if (level_ > 0 && level_ <= depth_) line();
}

JsonWriter& JsonWriter::begin(char bracket) {
  before_item();
  text_ += bracket;
  ++level_;
  first_ = true;
  return *this;
}

JsonWriter& JsonWriter::end(char bracket) {
  const bool split = level_ <= depth_ && !first_;
  --level_;
  if (split) line();
  text_ += bracket;
  first_ = false;
  return *this;
}

JsonWriter& JsonWriter::key(std::string_view name) {
  value(name);
  text_ += ": ";
  after_key_ = true;
  return *this;
}

JsonWriter& JsonWriter::value(double number) {
  if (!std::isfinite(number)) return null();
  before_item();
  append_number(text_, number);
  return *this;
}

JsonWriter& JsonWriter::value(long number) {
  before_item();
  append_number(text_, number);
  return *this;
}

JsonWriter& JsonWriter::value(bool truth) {
  before_item();
  text_ += truth ? "true" : "false";
  return *this;
}

JsonWriter& JsonWriter::raw(std::string_view json) {
  before_item();
  text_ += json;
  return *this;
}

JsonWriter& JsonWriter::null() {
  before_item();
  text_ += "null";
  return *this;
}

JsonWriter& JsonWriter::value(std::string_view words) {
  before_item();
  text_ += '"';
  for (std::size_t i = 0; i < words.size();) {
    const std::size_t length = character_length(words, i);
    const char32_t c = length == 0 ? U'\ufffd' : code_point(words.substr(i, length));
    if (c == '"' || c == '\\')
      text_ += '\\', text_ += words[i];
    else if (length > 0 && is_visible(c))
      text_ += words.substr(i, length);
    else
      append_escape(text_, c);
    i += std::max<std::size_t>(length, 1);
  }
  text_ += '"';
  return *this;
}

JsonWriter& JsonWriter::value(std::span<const double> numbers) {
  before_item();
  text_ += '[';
  bool first = true;
  for (const double x : numbers) {
    if (!first) text_ += ", ";
    first = false;
    if (std::isfinite(x))
      append_number(text_, x);
    else
      text_ += "null";
  }
  text_ += ']';
  return *this;
}

JsonWriter& JsonWriter::value(const Vec3& v) {
  const double numbers[] = {v.x, v.y, v.z};
  return value(std::span<const double>(numbers));
}

JsonWriter& JsonWriter::value(const Quat& quaternion) {
  const Quat q = with_positive_w(quaternion);
  const double numbers[] = {q.w, q.x, q.y, q.z};
  return value(std::span<const double>(numbers));
}

}  // namespace momentree::io
