#include <algorithm>
#include <array>
#include <filesystem>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/models/import/height_grid.hpp>
#include <momentree/models/mesh/source.hpp>
#include <momentree/models/mesh/split.hpp>
#include <momentree/scenario/keys/described.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/text/files/file_name.hpp>

namespace momentree::io {

namespace {

using namespace type;

// A primitive of one size is its value, one of several is a table.
template <class P>
constexpr KeyTable primitive_table{
    .name = P::info.key, .definition = P::info.key, .about = P::info.about, .described = &keys_of<P>};

KeyList primitive_keys() {
  struct Made {
    std::list<std::string> texts;
    std::vector<Key> keys;
  };
  static const Made made = [] {
    Made all;
    contact::each_primitive([&all]<class P>(const P&) {
      const KeyList sizes = keys_of<P>();
      if (sizes.size() > 1) return all.keys.push_back({P::info.key, table(primitive_table<P>), ""});
      all.texts.push_back(std::string(P::info.about) + ": " + sizes[0].about);
      all.keys.push_back({P::info.key, sizes[0].type, all.texts.back().c_str()});
    });
    return all;
  }();
  return made.keys;
}

// The kinds of shapes, separated by spaces.
constexpr auto kinds_after(std::string_view first) {
  std::array<char, 256> text{};
  std::size_t size = 0;
  const auto add = [&](std::string_view word) {
    if (size > 0) text[size++] = ' ';
    for (const char c : word) text[size++] = c;
  };
  if (!first.empty()) add(first);
  contact::each_primitive([&](const auto& primitive) { add(primitive.info.key); });
  add("mesh");
  return text;
}
constexpr auto kinds_of_bodies = kinds_after(""), kinds_of_ground = kinds_after("plane heightmap");

constexpr Key ground_entries[] = {
    {"plane", vector(dimension::number), "A plane through the origin of 'at', with the ground below it: its normal"},
    {"heightmap", other(R"({"anyOf": [{"type": "string"},
      {"type": "array", "items": {"type": "array", "items": {"type": "number"}, "minItems": 2}, "minItems": 2}]})"),
     "The ground below a grid of heights: a PNG image, or rows of numbers, that of the largest y first"},
    {"size", vector(dimension::length), "Of a heightmap: its extents along x and y, and the height of white, or of the number 1"},
};
constexpr Key shape_entries[] = {
    {"mesh", string, "A mesh: a file in the scenario's folder or below it"},
    {"scale", other(R"({"anyOf": [{"type": ["number", "string"]},
      {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 3, "maxItems": 3}]})"),
     "Scale of a mesh: one factor, or one along each axis", "1"},
    {"split", other(R"({"type": "number", "minimum": 0.01, "maximum": 1})"),
     "A closed mesh touches with convex parts of this concavity, of which 0.05 is usual; default: with its hull"},
    {"at", table(placement_table), "Placement of the shape's centre in the body's frame"},
    {"colour", string, "Colour: \"#rrggbb\" or a name; default: that of the mechanism"},
    {"color", string, "The same as colour"},
};
constexpr KeyList shape_keys = shape_entries;

bool is_colour(const std::string& text) {
  const auto hexadecimal = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); };
  return text.size() == 7 && text[0] == '#' && std::all_of(text.begin() + 1, text.end(), hexadecimal);
}

const std::vector<std::string>& colour_names() {
  static const std::vector<std::string> names{"black", "white",  "gray",    "grey",  "silver", "red",  "maroon",   "orange",
                                              "gold",  "yellow", "olive",   "green", "lime",   "teal", "cyan",     "blue",
                                              "navy",  "purple", "magenta", "pink",  "brown",  "tan",  "steelblue"};
  return names;
}

void read_colour(Fields& fields, std::string_view key, std::string& colour, Diagnostics& out) {
  const auto text = fields.string(key);
  if (!text) return;
  if (is_colour(*text) || std::find(colour_names().begin(), colour_names().end(), *text) != colour_names().end()) {
    colour = *text;
    return;
  }
  const std::string hint = did_you_mean(*text, colour_names());
  out.error(fields.place_of(key), std::string(key) + ": " + in_quotes(*text) + " is not a colour",
            hint.empty() ? "write \"#rrggbb\"" : hint);
}

// A file that a shape names: its name, its path if it exists, and whether files are accessed at all. Files must be in the
// scenario's folder or below it: a scenario from elsewhere must not cause access to other files.
struct NamedFile {
  std::string name, path;
};
std::optional<NamedFile> read_file_name(const Value& value, const char* key, Reading& reading) {
  const auto file = read_string(value, key, reading.out);
  if (!file) return std::nullopt;
  const auto refuse = [&](const std::string& what, const std::string& hint) {
    reading.out.error(value.place, std::string(key) + ": " + in_quotes(*file) + " " + what, hint);
    return std::nullopt;
  };
  if (file->empty() || leaves_folder(*file)) return refuse("is not a file in the scenario's folder or below it", "copy it there");
  if (!reading.looks_at_files) return NamedFile{*file, ""};
  const std::filesystem::path path = std::filesystem::path(reading.folder) / *file;
  if (!reading.enclosure.holds(path))
    return refuse("leads out of the scenario's folder through a symbolic link", "copy the file there");
  const auto reason = why_unreadable(path.string(), key);
  if (reason && !reason->missing) return refuse(reason->what, reason->hint);
  return NamedFile{*file, reason ? "" : path.lexically_normal().string()};
}

void read_mesh(const Value& value, bool drawn, Shape& shape, Reading& reading) {
  const auto file = read_file_name(value, "mesh", reading);
  if (!file) return;
  if (reading.looks_at_files && file->path.empty() && drawn)
    reading.out.warning(value.place, "mesh: there is no file " + in_quotes(file->name) + ": the body is drawn without it",
                        "it is looked for in the scenario's folder");
  shape.kind = Shape::Kind::mesh;
  shape.mesh = file->name;
  if (file->path.empty()) return;
  shape.source = std::make_shared<MeshSource>(MeshSource{file->path, "", "", {}, reading.scenario.path, value.place});
}

// Rows of numbers, the last of which is that of the smallest y.
std::optional<HeightGrid> read_rows(const Value::Array& rows, const Value& value, Diagnostics& out) {
  const std::size_t columns = rows.empty() || !rows.front().array() ? 0 : rows.front().array()->size();
  if (rows.size() < 2 || columns < 2) {
    out.error(value.place, "heightmap: expected rows of numbers", "for example heightmap = [[0, 0.1], [0.2, 0]]");
    return std::nullopt;
  }
  HeightGrid grid{static_cast<int>(columns), static_cast<int>(rows.size())};
  for (std::size_t r = rows.size(); r-- > 0;) {
    const Value::Array* const row = rows[r].array();
    if (row == nullptr || row->size() != columns) {
      out.error(rows[r].place, "heightmap: row " + std::to_string(r + 1) + " has " +
                                   (row == nullptr ? "no numbers" : std::to_string(row->size()) + " numbers") +
                                   ", the first one " + std::to_string(columns));
      return std::nullopt;
    }
    for (const Value& number : *row) {
      const auto height = read_number(number, dimension::number, "heightmap", out);
      if (!height) return std::nullopt;
      grid.values.push_back(*height);
    }
  }
  return grid;
}

void read_heightmap(const Value& value, Fields& fields, Shape& shape, Reading& reading) {
  Diagnostics& out = reading.out;
  fields.require("size", "its extents along x and y, and the height of white, or of the number 1: size = [10, 10, 1]");
  shape.size = fields.vec3("size").value_or(Vec3{1, 1, 1});
  if (!(shape.size.x > 0 && shape.size.y > 0 && shape.size.z > 0))
    out.error(fields.place_of("size"), "size: its three numbers must be greater than 0");
  std::optional<HeightGrid> grid;
  if (const Value::Array* const rows = value.array()) {
    grid = read_rows(*rows, value, out);
  } else if (const auto file = read_file_name(value, "heightmap", reading)) {
    if (file->path.empty())
      return out.error(value.place,
                       reading.looks_at_files ? "heightmap: there is no file " + in_quotes(file->name)
                                              : "heightmap: a scenario read from text cannot name files",
                       reading.looks_at_files ? "it is looked for in the scenario's folder" : "give it rows of numbers");
#ifdef __cpp_exceptions
    try {
      grid = read_height_image(file->path);
    } catch (const Error& error) {
      return out.error(value.place, "heightmap: " + in_quotes(file->name) + " " + error.problem, error.hint);
    }
#endif
  }
  if (!grid) return;
  shape.kind = Shape::Kind::heights;
  shape.heights = std::make_shared<const HeightGrid>(std::move(*grid));
}

// One factor, or one along each axis.
void read_scale(const Value& value, Shape& shape, Diagnostics& out) {
  if (value.array()) {
    shape.scale = read_vec3(value, dimension::number, "scale", out).value_or(shape.scale);
  } else if (const auto all = read_number(value, dimension::number, "scale", out)) {
    shape.scale = {*all, *all, *all};
  }
  if (shape.scale.x == 0 || shape.scale.y == 0 || shape.scale.z == 0) out.error(value.place, "scale: must not be 0");
}

// The only size of a primitive.
struct SizeReader {
  const Value& value;
  const char* key;
  Diagnostics& out;
  void operator()(const char*, double& x, const Field& field) const {
    x = read_number(value, field.dimension, key, out).value_or(x);
    check(x > 0, field);
  }
  void operator()(const char*, Vec3& x, const Field& field) const {
    x = read_vec3(value, field.dimension, key, out).value_or(x);
    check(x.x > 0 && x.y > 0 && x.z > 0, field);
  }
  void check(bool positive, const Field& field) const {
    if (!positive) out.error(value.place, std::string(key) + ": " + field.about + " must be greater than 0");
  }
};

template <class P>
void read_primitive(const Value& value, P& primitive, Diagnostics& out) {
  if (keys_of<P>().size() == 1) {
    const SizeReader reader{value, P::info.key, out};
    return describe(reader, primitive);
  }
  Fields fields(value, primitive_table<P>, out);
  FieldReader reader(fields);
  describe(reader, primitive);
  fields.finish();
}

// "box, sphere and mesh"
std::string in_words(std::string_view names) {
  std::string text;
  for (const char c : names) text += c == ' ' ? ", " : std::string(1, c);
  return text.replace(text.rfind(", "), 2, " and ");
}

Shape read_one(const Value& value, ShapeUse use, Reading& reading) {
  Diagnostics& out = reading.out;
  const bool of_ground = use == ShapeUse::ground;
  Fields fields(value, of_ground ? ground_shape_table : shape_table, out);
  Shape shape;
  int kinds = 0;
  contact::each_primitive([&](auto primitive) {
    const Value* const given = fields.find(primitive.info.key);
    if (given == nullptr) return;
    ++kinds;
    read_primitive(*given, primitive, out);
    shape = Shape::of(primitive);
  });
  if (const Value* plane = of_ground ? fields.find("plane") : nullptr; plane && ++kinds) {
    shape.kind = Shape::Kind::plane;
    shape.size = read_vec3(*plane, dimension::number, "plane", out).value_or(z_axis);
    if (shape.size == Vec3{}) out.error(plane->place, "plane: its normal must not be zero", "for example plane = [0, 0, 1]");
  }
  if (const Value* heightmap = of_ground ? fields.find("heightmap") : nullptr; heightmap && ++kinds)
    read_heightmap(*heightmap, fields, shape, reading);
  if (const Value* mesh = fields.find("mesh"); mesh && ++kinds) read_mesh(*mesh, use == ShapeUse::drawn, shape, reading);
  if (const Value* scale = fields.find("scale")) {
    if (shape.kind == Shape::Kind::mesh || fields.has("mesh"))
      read_scale(*scale, shape, out);
    else
      out.error(scale->place, "scale: only a mesh is scaled", "give the shape its size");
  }
  if (const Value* split = fields.find("split")) {
    if (shape.kind == Shape::Kind::mesh || fields.has("mesh"))
      shape.split = read_split(*split, out);
    else
      out.error(split->place, "split: only a mesh is split");
  }
  if (kinds != 1 && value.table())
    out.error(fields.place(), "a shape is one of " + in_words(of_ground ? kinds_of_ground.data() : kinds_of_bodies.data()),
              kinds > 1 ? "make the others further entries of a list" : "for example { sphere = 0.1 }");
  shape.at = fields.pose("at").value_or(Pose{});
  read_colour(fields, "colour", shape.colour, out);
  read_colour(fields, "color", shape.colour, out);
  fields.finish();
  return shape;
}

}  // namespace

constinit const KeyTable shape_table{.name = "shape",
                                     .definition = "shape",
                                     .about = "A shape, for pictures only",
                                     .rules = {{KeyRule::How::one, kinds_of_bodies.data()}},
                                     .shared = {&shape_keys},
                                     .described = &primitive_keys};
constinit const KeyTable ground_shape_table{.name = "shape",
                                            .definition = "ground_shape",
                                            .about = "What bodies touch, fixed in the world",
                                            .own = ground_entries,
                                            .rules = {{KeyRule::How::one, kinds_of_ground.data()}},
                                            .shared = {&shape_keys},
                                            .described = &primitive_keys};

double read_split(const Value& value, Diagnostics& out) {
  const double split = read_number(value, dimension::number, "split", out).value_or(usual_split);
  if (split >= least_split && split <= 1) return split;
  out.error(value.place, "split: must be from 0.01 to 1",
            "0.05 is usual: parts reach up to 2.5 % of the mesh's extent outside of it");
  return usual_split;
}

Shape read_shape(const Value& value, Reading& reading, ShapeUse use) {
  const Value::Array* several = value.array();
  if (!several) return read_one(value, use, reading);
  if (several->empty())
    reading.out.error(value.place, std::string(use == ShapeUse::drawn ? "shape" : "collision") + ": the list has no shape",
                      use == ShapeUse::body ? "leave it out, or write collision = \"none\"" : "leave it out");
  Shape all;
  for (const Value& each : *several) {
    Shape one = read_one(each, use, reading);
    if (&each == &several->front())
      all = std::move(one);
    else
      all.more.push_back(std::move(one));
  }
  return all;
}

}  // namespace momentree::io
