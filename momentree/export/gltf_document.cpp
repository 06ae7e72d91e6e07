#include <momentree/export/gltf_document.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

#include <momentree/base/error.hpp>
#include <momentree/export/bytes.hpp>
#include <momentree/text/colour.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

namespace {

constexpr int component_float = 5126, component_short = 5123, component_int = 5125;

template <class Numbers>
void write_floats(JsonWriter& json, const char* key, const Numbers& numbers) {
  json.key(key).begin_array();
  for (const float x : numbers) json.value(static_cast<double>(x));
  json.end_array();
}

void write_numbers(JsonWriter& json, const char* key, const std::vector<int>& numbers) {
  json.key(key).begin_array();
  for (const int number : numbers) json.value(number);
  json.end_array();
}

/// Writes the list `key` with an object for each item; glTF has no empty lists.
template <class Items, class Write>
void write_list(JsonWriter& json, const char* key, const Items& items, const Write& write) {
  if (items.empty()) return;
  json.key(key).begin_array();
  for (const auto& item : items) {
    json.begin_object();
    write(item);
    json.end_object();
  }
  json.end_array();
}

/// A member whose value is JSON text.
void write_json(JsonWriter& json, std::string& text, const char* key, const std::string& document) {
  if (document.empty()) return;
  json.key(key).null();
  text.resize(text.size() - 4);
  text += document;
}

}  // namespace

int GltfDocument::add_node(Node node, int parent) {
  const int number = static_cast<int>(nodes_.size());
  nodes_.push_back(std::move(node));
  (parent < 0 ? roots_ : nodes_[static_cast<std::size_t>(parent)].children).push_back(number);
  return number;
}

int GltfDocument::material(const std::string& colour, bool open) {
  const auto known = std::find_if(materials_.begin(), materials_.end(),
                                  [&](const Material& each) { return each.colour == colour && each.open == open; });
  if (known != materials_.end()) return static_cast<int>(known - materials_.begin());
  materials_.push_back({colour, open});
  return static_cast<int>(materials_.size()) - 1;
}

int GltfDocument::add_view(std::string_view bytes, Target target) {
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  views_.push_back({bytes_.size(), bytes.size(), target});
  bytes_ += bytes;
  return static_cast<int>(views_.size()) - 1;
}

int GltfDocument::add_floats(std::span<const float> numbers, std::size_t width, Target target, bool bounds) {
  std::string bytes;
  bytes.reserve(4 * numbers.size());
  for (const float x : numbers) append_little_endian(bytes, std::bit_cast<std::uint32_t>(x));
  static constexpr const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  Accessor accessor{add_view(bytes, target), component_float, numbers.size() / width, types[width]};
  if (bounds) {
    accessor.low.assign(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(width));
    accessor.high = accessor.low;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      accessor.low[i % width] = std::min(accessor.low[i % width], numbers[i]);
      accessor.high[i % width] = std::max(accessor.high[i % width], numbers[i]);
    }
  }
  accessors_.push_back(std::move(accessor));
  return static_cast<int>(accessors_.size()) - 1;
}

int GltfDocument::add_triangles(const Triangles& triangles) {
  Geometry geometry{add_floats(triangles.positions, 3, Target::vertices, true), -1, -1};
  if (!triangles.normals.empty()) geometry.normals = add_floats(triangles.normals, 3, Target::vertices, false);
  std::string bytes;
  const bool small = triangles.positions.size() / 3 <= 65535;  // the greatest index would mean a restart
  for (const std::uint32_t index : triangles.indices)
    small ? append_little_endian(bytes, static_cast<std::uint16_t>(index)) : append_little_endian(bytes, index);
  accessors_.push_back(
      {add_view(bytes, Target::indices), small ? component_short : component_int, triangles.indices.size(), "SCALAR"});
  geometry.indices = static_cast<int>(accessors_.size()) - 1;
  geometries_.push_back(geometry);
  return static_cast<int>(geometries_.size()) - 1;
}

int GltfDocument::add_mesh(int triangles, int material) {
  meshes_.push_back({triangles, material});
  return static_cast<int>(meshes_.size()) - 1;
}

int GltfDocument::add_times(std::span<const float> times) { return add_floats(times, 1, Target::none, true); }

void GltfDocument::animate(int node, Path path, int times, std::span<const float> values, bool steps) {
  samplers_.push_back({times, add_floats(values, path == Path::rotation ? 4 : 3, Target::none, false), steps});
  channels_.push_back({node, path});
}

std::string GltfDocument::json(const std::string& generator, const std::string& title) const {
  std::string text;
  JsonWriter json(text);
  json.begin_object().key("asset").begin_object().member("version", "2.0").member("generator", generator).end_object();
  json.member("scene", 0).key("scenes").begin_array().begin_object().member("name", title);
  write_numbers(json, "nodes", roots_);
  write_json(json, text, "extras", extras_);
  json.end_object().end_array();
  write_list(json, "nodes", nodes_, [&](const Node& node) {
    json.member("name", node.name);
    if (node.mesh >= 0) json.member("mesh", node.mesh);
    if (node.translation) write_floats(json, "translation", *node.translation);
    if (node.rotation) write_floats(json, "rotation", *node.rotation);
    if (node.scale) write_floats(json, "scale", *node.scale);
    if (!node.children.empty()) write_numbers(json, "children", node.children);
    write_json(json, text, "extras", node.extras);
  });
  write_list(json, "meshes", meshes_, [&](const Mesh& mesh) {
    const Geometry& geometry = geometries_[static_cast<std::size_t>(mesh.triangles)];
    json.key("primitives").begin_array().begin_object().key("attributes").begin_object();
    json.member("POSITION", geometry.positions);
    if (geometry.normals >= 0) json.member("NORMAL", geometry.normals);
    json.end_object().member("indices", geometry.indices).member("material", mesh.material).end_object().end_array();
  });
  write_list(json, "materials", materials_, [&](const Material& material) {
    const Rgb rgb = rgb_of(material.colour);
    json.member("name", material.colour).key("pbrMetallicRoughness").begin_object();
    write_floats(json, "baseColorFactor",
                 Float4{static_cast<float>(linear_light(rgb.r)), static_cast<float>(linear_light(rgb.g)),
                        static_cast<float>(linear_light(rgb.b)), 1});
    json.member("metallicFactor", 0).member("roughnessFactor", 0.7).end_object();
    if (material.open) json.member("doubleSided", true);
  });
  if (!samplers_.empty()) {
    json.key("animations").begin_array().begin_object().member("name", title);
    int number = 0;
    write_list(json, "channels", channels_, [&](const Channel& channel) {
      static constexpr const char* paths[] = {"translation", "rotation", "scale"};
      json.member("sampler", number++).key("target").begin_object();
      json.member("node", channel.node).member("path", paths[static_cast<int>(channel.path)]).end_object();
    });
    write_list(json, "samplers", samplers_, [&](const Sampler& sampler) {
      json.member("input", sampler.input).member("output", sampler.output);
      json.member("interpolation", sampler.steps ? "STEP" : "LINEAR");
    });
    json.end_object().end_array();
  }
  write_list(json, "accessors", accessors_, [&](const Accessor& accessor) {
    json.member("bufferView", accessor.view).member("componentType", accessor.component);
    json.member("count", static_cast<long>(accessor.count)).member("type", accessor.type);
    if (!accessor.low.empty()) write_floats(json, "min", accessor.low), write_floats(json, "max", accessor.high);
  });
  write_list(json, "bufferViews", views_, [&](const View& view) {
    json.member("buffer", 0).member("byteOffset", static_cast<long>(view.offset));
    json.member("byteLength", static_cast<long>(view.length));
    if (view.target != Target::none) json.member("target", static_cast<int>(view.target));
  });
  if (!bytes_.empty())
    json.key("buffers")
        .begin_array()
        .begin_object()
        .member("byteLength", static_cast<long>(bytes_.size()))
        .end_object()
        .end_array();
  json.end_object();
  return text;
}

std::string GltfDocument::binary(const std::string& generator, const std::string& title) const {
  std::string text = json(generator, title);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::size_t padded = (bytes_.size() + 3) / 4 * 4;
  const std::size_t size = 12 + 8 + text.size() + (padded > 0 ? 8 + padded : 0);
  if (size > 0xffffffffu)
    throw_error({"the file would have more than 4 GiB, which glTF does not allow", "", "record fewer rows: output.every"});
  std::string file;
  file.reserve(size);
  file += "glTF";
  for (const std::size_t number : {std::size_t{2}, size, text.size()})
    append_little_endian(file, static_cast<std::uint32_t>(number));
  file += "JSON" + text;
  if (padded == 0) return file;
  append_little_endian(file, static_cast<std::uint32_t>(padded));
  file += "BIN";
  file += '\0';
  file += bytes_;
  file.resize(size);
  return file;
}

}  // namespace momentree::io
