#include <momentree/export/picture/svg_text.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace momentree::io {
namespace {

/// Length of the UTF-8 sequence at the start of `text`; 0 if it is invalid or a character that XML forbids.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return first >= 0x20 || first == '\t' || first == '\n' || first == '\r' ? 1 : 0;
  const std::size_t length = first >= 0xF0 && first < 0xF5   ? 4
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xC2 && first < 0xE0 ? 2
                                                             : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  if (first == 0xE0 && byte(1) < 0xA0) return 0;                      // overlong
  if (first == 0xF0 && byte(1) < 0x90) return 0;                      // overlong
  if (first == 0xF4 && byte(1) > 0x8F) return 0;                      // beyond U+10FFFF
  if (first == 0xED && byte(1) > 0x9F) return 0;                      // surrogates
  if (first == 0xEF && byte(1) == 0xBF && byte(2) >= 0xBE) return 0;  // U+FFFE, U+FFFF
  return length;
}

}  // namespace

std::string xml_escaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    switch (length == 1 ? text.front() : '\0') {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&apos;"; break;
      default: out += length == 0 ? "\xEF\xBF\xBD" : text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

std::string pixels(double length) {
  std::array<char, 32> text{};
  const double rounded = std::round(length * 10) / 10 + 0.0;  // + 0.0: no "-0"
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), std::clamp(rounded, -1e7, 1e7), std::chars_format::fixed).ptr;
  return {text.data(), end};
}

std::string pixels(const Point2& p) { return pixels(p.x) + " " + pixels(p.y); }

std::string plain_number(double value) {
  std::array<char, 32> text{};
  const double clean = std::abs(value) < 1e-12 ? 0.0 : value;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), clean, std::chars_format::general, 6).ptr;
  return {text.data(), end};
}

std::string frame_time(double time, double every) {
  const std::string step = plain_number(every);
  const std::size_t dot = step.find('.');
  if (dot == std::string::npos || step.find('e') != std::string::npos) return plain_number(time);
  const int decimals = static_cast<int>(step.size() - dot - 1);
  const double unit = std::pow(10.0, -decimals);
  if (std::abs(time - std::round(time / unit) * unit) > 1e-3 * unit) return plain_number(time);  // the row is at another time
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), time + 0.0, std::chars_format::fixed, decimals).ptr;
  return {text.data(), end};
}

double text_width(std::string_view text, double font_size) {
  double letters = 0;
  for (const char c : text)
    if ((static_cast<unsigned char>(c) & 0xC0) != 0x80)
      letters += c == '.' || c == ',' || c == ' ' || c == 'i' || c == 'l' ? 0.32 : 0.58;
  return letters * font_size;
}

std::string mechanism_colour(std::size_t n) {
  static constexpr std::array<const char*, 8> colours{"#1f5fa8", "#d1540a", "#0a8a5f", "#a8388a",
                                                      "#b07c00", "#3a9bd6", "#7a5230", "#5c5c5c"};
  return colours[n % colours.size()];
}

std::string tint(const std::string& colour, double strength) {
  if (colour.size() != 7 || colour[0] != '#') return colour;
  std::string mixed = "#";
  for (std::size_t k = 1; k < 7; k += 2) {
    unsigned part = 0;
    const auto [stop, error] = std::from_chars(colour.data() + k, colour.data() + k + 2, part, 16);
    if (error != std::errc{} || stop != colour.data() + k + 2) return colour;
    const auto value = static_cast<unsigned>(std::lround(255 - strength * (255 - part)));
    mixed += "0123456789abcdef"[value / 16];
    mixed += "0123456789abcdef"[value % 16];
  }
  return mixed;
}

std::string safe_colour(const std::string& colour, const std::string& otherwise) {
  const auto good = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '#'; };
  return !colour.empty() && colour.size() <= 32 && std::all_of(colour.begin(), colour.end(), good) ? colour : otherwise;
}

}  // namespace momentree::io
