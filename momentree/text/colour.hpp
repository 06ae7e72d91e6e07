#pragma once
// The colours of shapes as numbers.
#include <string>
#include <string_view>

namespace momentree::io {

/// A colour of a scenario as "#rrggbb": the names have their values in CSS. Empty for anything else.
std::string hex_colour(std::string_view colour);

/// Red, green and blue from 0 to 1 (sRGB).
struct Rgb {
  double r = 0, g = 0, b = 0;
};
/// Of "#rrggbb"; black for anything else.
Rgb rgb_of(std::string_view hex);

/// The linear light of an sRGB level from 0 to 1.
double linear_light(double level);

}  // namespace momentree::io
