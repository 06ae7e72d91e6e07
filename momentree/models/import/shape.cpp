#include <momentree/models/import/shape.hpp>

#include <algorithm>
#include <cmath>

namespace momentree::io {

std::string colour_text(const std::vector<double>& rgb) {
  constexpr const char* digits = "0123456789abcdef";
  std::string text = "#";
  for (std::size_t i = 0; i < 3; ++i) {
    const long level = std::lround(255 * std::clamp(rgb[i], 0.0, 1.0));
    text += digits[level >> 4];
    text += digits[level & 15];
  }
  return text;
}

}  // namespace momentree::io
