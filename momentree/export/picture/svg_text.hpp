#pragma once
// SVG text helpers: escaping, rounded numbers, colours.
#include <cstddef>
#include <string>
#include <string_view>

#include <momentree/export/picture/projection.hpp>

namespace momentree::io {

/// Text for an XML element or attribute: & < > " ' as entities; characters that XML 1.0 forbids and invalid UTF-8 become
/// U+FFFD.
std::string xml_escaped(std::string_view text);

/// A length in pixels, to 0.1, without trailing zeros: "12.3", "7", "0".
std::string pixels(double length);

/// "12.3 4.5"
std::string pixels(const Point2& p);

/// A number with at most six significant digits, without trailing zeros: "1.8", "0.2".
std::string plain_number(double value);

/// The time of a frame, with as many decimals as the time between frames has: "1.0" among "0.8" and "1.2".
std::string frame_time(double time, double every);

/// Approximate width of the text (px) in proportional fonts.
double text_width(std::string_view text, double font_size);

/// Colour of the n-th mechanism, distinguishable for the colour-blind; the colours repeat after eight.
std::string mechanism_colour(std::size_t n);

/// "#rrggbb" mixed with white; 1: the colour itself. Named colours are left unchanged.
std::string tint(const std::string& colour, double strength);

/// The colour if it is valid in SVG ("#rrggbb", a name), else `otherwise`.
std::string safe_colour(const std::string& colour, const std::string& otherwise);

}  // namespace momentree::io
