#pragma once
// Heights of a field as files give them.
#include <string>
#include <vector>

namespace momentree::io {

/// Numbers on a grid, row by row from −y to y, in each row from −x to x.
struct HeightGrid {
  int columns = 0, rows = 0;  ///< at least 2 of each
  std::vector<double> values{};
};

inline constexpr long most_heights = 16'000'000;

/// A PNG image, from 0 (black) to 1 (white); its upper edge is at y. Throws Error.
HeightGrid read_height_image(const std::string& path);
/// A file as MuJoCo writes them: the numbers of rows and columns as 32-bit integers, then 32-bit floats. Throws Error.
HeightGrid read_height_file(const std::string& path);

}  // namespace momentree::io
