// Height fields of <asset>, which geoms name.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/models/import/height_grid.hpp>
#include <momentree/models/mjcf/parts.hpp>

namespace momentree::io::mjcf {

namespace {

namespace fs = std::filesystem;

// Rows and columns, and the elevation of the first row at the largest y.
std::shared_ptr<const HeightGrid> read_elevation(Attributes& attributes, XmlElement element, XmlFile& file) {
  constexpr double most = 1e5;
  const double rows = attributes.number("nrow").value_or(0), columns = attributes.number("ncol").value_or(0);
  if (!(rows >= 2 && columns >= 2 && rows <= most && columns <= most) || rows != std::floor(rows) ||
      columns != std::floor(columns)) {
    file.error({element}, "an <hfield> without a file has nrow and ncol, both at least 2", "");
    return nullptr;
  }
  const auto count = static_cast<std::size_t>(rows * columns), across = static_cast<std::size_t>(columns);
  HeightGrid grid{static_cast<int>(columns), static_cast<int>(rows)};
  if (count > static_cast<std::size_t>(most_heights)) {
    file.error({element}, "<hfield> has more than " + std::to_string(most_heights) + " heights", "make it coarser");
    return nullptr;
  }
  grid.values.assign(count, 0.0);
  const auto given = attributes.has("elevation") ? attributes.numbers("elevation", 1, count + 1) : std::nullopt;
  if (given && given->size() != count) {
    attributes.error("elevation", "elevation: " + std::to_string(count) + " numbers are needed, for nrow rows of ncol");
    return nullptr;
  }
  for (std::size_t k = 0; given && k < count; ++k) grid.values[count - across * (k / across + 1) + k % across] = (*given)[k];
  return std::make_shared<const HeightGrid>(std::move(grid));
}

// From 0 to 1, as MuJoCo scales all of them.
HeightGrid scaled(HeightGrid grid) {
  const auto [low, high] = std::minmax_element(grid.values.begin(), grid.values.end());
  const double least = *low, extent = *high - *low;
  for (double& value : grid.values) value = extent > 0 ? (value - least) / extent : 0;
  return grid;
}

}  // namespace

void read_field_asset(XmlElement element, Reading& reading) {
  XmlFile& file = reading.file_of(element);
  check_attributes(element, {"content_type", "file", "nrow", "ncol", "elevation", "size"}, reading);
  Attributes attributes(element, "", reading);
  Shape shape;
  std::string name;
  if (const auto own = element.find("name")) name = element.attribute(*own);
  const auto size = attributes.numbers("size", 4);
  if (!attributes.has("size")) file.error({element}, "<hfield> has no 'size'", "size=\"radius_x radius_y elevation_z base_z\"");
  const bool sized = size && std::all_of(size->begin(), size->end(), [](double x) { return x > 0; });
  if (size && !sized) attributes.error("size", "size: its four numbers must be greater than 0");
  const auto given = attributes.string("file");
  if (given && name.empty()) name = fs::path(*given).stem().string();
  std::shared_ptr<const HeightGrid> grid;
  if (given) {
    const fs::path path = reading.compiler.strippath ? fs::path(*given).filename() : fs::path(*given);
    grid = reading.import.read_heights((fs::path(reading.compiler.meshdir) / path).lexically_normal().generic_string(),
                                       attributes.at("file"), file);
  } else {
    grid = read_elevation(attributes, element, file);
  }
  if (grid && sized) {
    shape.kind = Shape::Kind::heights;
    shape.size = {2 * (*size)[0], 2 * (*size)[1], (*size)[2]};
    shape.heights = std::make_shared<const HeightGrid>(scaled(*grid));
  }
  reading.fields.emplace(std::move(name), std::move(shape));
}

}  // namespace momentree::io::mjcf
