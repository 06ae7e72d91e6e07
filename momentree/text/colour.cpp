#include <momentree/text/colour.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace momentree::io {

namespace {

int level_of(std::string_view hex, std::size_t at) {
  unsigned level = 0;
  const auto [stop, error] = std::from_chars(hex.data() + at, hex.data() + at + 2, level, 16);
  return error == std::errc{} && stop == hex.data() + at + 2 ? static_cast<int>(level) : -1;
}

}  // namespace

std::string hex_colour(std::string_view colour) {
  static constexpr std::pair<std::string_view, const char*> names[] = {
      {"black", "#000000"}, {"white", "#ffffff"},  {"gray", "#808080"},     {"grey", "#808080"},    {"silver", "#c0c0c0"},
      {"red", "#ff0000"},   {"maroon", "#800000"}, {"orange", "#ffa500"},   {"gold", "#ffd700"},    {"yellow", "#ffff00"},
      {"olive", "#808000"}, {"green", "#008000"},  {"lime", "#00ff00"},     {"teal", "#008080"},    {"cyan", "#00ffff"},
      {"blue", "#0000ff"},  {"navy", "#000080"},   {"purple", "#800080"},   {"magenta", "#ff00ff"}, {"pink", "#ffc0cb"},
      {"brown", "#a52a2a"}, {"tan", "#d2b48c"},    {"steelblue", "#4682b4"}};
  for (const auto& [name, value] : names)
    if (name == colour) return value;
  const bool valid =
      colour.size() == 7 && colour[0] == '#' && level_of(colour, 1) >= 0 && level_of(colour, 3) >= 0 && level_of(colour, 5) >= 0;
  return valid ? std::string(colour) : "";
}

Rgb rgb_of(std::string_view hex) {
  if (hex.size() != 7) return {};
  const auto share = [hex](std::size_t at) { return std::max(level_of(hex, at), 0) / 255.0; };
  return {share(1), share(3), share(5)};
}

double linear_light(double level) { return level <= 0.04045 ? level / 12.92 : std::pow((level + 0.055) / 1.055, 2.4); }

}  // namespace momentree::io
