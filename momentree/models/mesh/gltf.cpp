// glTF 2.0 (.gltf with buffers inside or in files, .glb): triangles of the default scene, placed by its nodes, in the base
// colours of their materials.
#include <algorithm>
#include <deque>

#include <momentree/models/import/shape.hpp>
#include <momentree/models/mesh/formats.hpp>
#include <momentree/models/mesh/transform.hpp>
#include <momentree/text/base64.hpp>
#include <momentree/text/json.hpp>

namespace momentree::io::mesh {

namespace {

const Value* member_of(const Value* value, std::string_view key) {
  const Value::Entry* entry = value ? value->find(key) : nullptr;
  return entry ? &entry->value : nullptr;
}

/// The member `key` as a count or an index; `otherwise` if it is absent.
std::size_t count_in(const Value* value, std::string_view key, std::size_t otherwise) {
  const Value* count = member_of(value, key);
  if (!count) return otherwise;
  const std::int64_t* number = count->integer();
  if (!number || *number < 0 || *number > 0xffffffff) refuse("'" + std::string(key) + "' is not a count");
  return static_cast<std::size_t>(*number);
}

std::string_view string_in(const Value* value, std::string_view key) {
  const Value* text = member_of(value, key);
  return text && text->string() ? std::string_view(*text->string()) : std::string_view{};
}

/// The numbers of an array; nothing if it is absent.
std::vector<double> numbers_in(const Value* value, std::string_view key, std::size_t size) {
  const Value* list = member_of(value, key);
  if (!list) return {};
  std::vector<double> numbers;
  if (list->array())
    for (const Value& each : *list->array())
      if (const auto number = each.number()) numbers.push_back(*number);
  if (numbers.size() != size) refuse("'" + std::string(key) + "' has not " + std::to_string(size) + " numbers");
  return numbers;
}

constexpr std::size_t no_index = static_cast<std::size_t>(-1);

class Gltf {
 public:
  Gltf(const Value& document, std::string_view binary, const std::string& submesh, const CompanionFiles& companions)
      : document_(document), submesh_(submesh) {
    if (const Value* required = member_of(&document, "extensionsRequired"); required && required->array())
      for (const Value& each : *required->array())
        if (each.string() && (*each.string() == "KHR_draco_mesh_compression" || *each.string() == "EXT_meshopt_compression"))
          refuse("it is compressed with " + *each.string(), "export it without compression");
    require_small_tables(document);
    visited_.resize(list("nodes").size());
    for (const Value& buffer : list("buffers")) {
      const bool inside = string_in(&buffer, "uri").empty();
      owned_.push_back(inside ? std::string() : buffer_of(buffer, companions));
      buffers_.push_back(inside && owned_.size() == 1 ? binary : std::string_view(owned_.back()));
    }
  }

  Mesh read() {
    Affine up;  // y of the file is z
    up.m[1][1] = up.m[2][2] = 0, up.m[1][2] = -1, up.m[2][1] = 1;
    const Value* scene = item("scenes", count_in(&document_, "scene", 0));
    if (scene)
      for (const std::size_t node : indices_in(scene, "nodes")) read_node(node, up, submesh_.empty(), 0);
    else
      for (std::size_t i = 0; i < list("meshes").size(); ++i) read_mesh(i, up, submesh_.empty());
    return std::move(mesh_);
  }

 private:
  const Value::Array& list(std::string_view key) const {
    static const Value::Array none;
    const Value* found = member_of(&document_, key);
    return found && found->array() ? *found->array() : none;
  }
  const Value* item(std::string_view key, std::size_t index) const {
    const Value::Array& all = list(key);
    return index < all.size() ? &all[index] : nullptr;
  }
  static std::vector<std::size_t> indices_in(const Value* value, std::string_view key) {
    std::vector<std::size_t> indices;
    const Value* found = member_of(value, key);
    if (found && found->array())
      for (const Value& each : *found->array())
        if (each.integer() && *each.integer() >= 0) indices.push_back(static_cast<std::size_t>(*each.integer()));
    return indices;
  }

  /// Members are searched for one after another.
  static void require_small_tables(const Value& value) {
    if (value.table() && value.table()->size() > 1000) refuse("an object has more than 1000 members");
    if (value.table())
      for (const Value::Entry& entry : *value.table()) require_small_tables(entry.value);
    if (value.array())
      for (const Value& each : *value.array()) require_small_tables(each);
  }

  static std::string buffer_of(const Value& buffer, const CompanionFiles& companions) {
    const std::string_view uri = string_in(&buffer, "uri");
    if (uri.starts_with("data:")) {
      const std::size_t comma = uri.find(";base64,");
      auto bytes = comma == std::string_view::npos ? std::nullopt : from_base64(uri.substr(comma + 8));
      if (!bytes) refuse("a buffer is not valid base64");
      return std::move(*bytes);
    }
    auto bytes = companions ? companions(std::string(uri)) : std::nullopt;
    if (!bytes) refuse("a buffer is not a file in the mesh's folder or below it", "export it as .glb");
    return std::move(*bytes);
  }

  /// The elements of an accessor: component(i, k) reads the k-th number of element i.
  struct Accessor {
    std::string_view bytes{};
    std::size_t count = 0, stride = 0, size = 0, type = 0;
    bool normalized = false;
    double component(std::size_t i, std::size_t k) const {
      const std::size_t at = i * stride + k * size;
      switch (type) {
        case 5120: return scaled(little_endian<std::int8_t>(bytes, at), 127);
        case 5121: return scaled(little_endian<std::uint8_t>(bytes, at), 255);
        case 5122: return scaled(little_endian<std::int16_t>(bytes, at), 32767);
        case 5123: return scaled(little_endian<std::uint16_t>(bytes, at), 65535);
        case 5125: return little_endian<std::uint32_t>(bytes, at);
        default: return double{little_endian<float>(bytes, at)};
      }
    }
    double scaled(double value, double largest) const { return normalized ? std::max(value / largest, -1.0) : value; }
  };

  Accessor accessor_of(std::size_t index, std::size_t components) const {
    const Value* accessor = item("accessors", index);
    if (!accessor) refuse("an accessor does not exist");
    if (member_of(accessor, "sparse")) refuse("it has sparse accessors", "export it without them");
    const Value* view = item("bufferViews", count_in(accessor, "bufferView", no_index));
    Accessor a;
    a.type = count_in(accessor, "componentType", 0);
    a.size = a.type == 5120 || a.type == 5121   ? 1
             : a.type == 5122 || a.type == 5123 ? 2
             : a.type == 5125 || a.type == 5126 ? 4
                                                : 0;
    if (!view || a.size == 0) refuse("an accessor has no view of a buffer, or numbers of an unknown type");
    if (const std::string_view shape = string_in(accessor, "type"); shape != (components == 3 ? "VEC3" : "SCALAR"))
      refuse("an accessor has elements of the wrong type");
    const std::size_t buffer = count_in(view, "buffer", no_index);
    if (buffer >= buffers_.size()) refuse("a buffer does not exist");
    const std::string_view bytes = buffers_[buffer];
    const std::size_t start = count_in(view, "byteOffset", 0), length = count_in(view, "byteLength", 0);
    const std::size_t offset = count_in(accessor, "byteOffset", 0);
    if (start > bytes.size() || length > bytes.size() - start || offset > length) refuse("a view reaches beyond its buffer");
    a.bytes = bytes.substr(start + offset, length - offset);
    a.count = count_in(accessor, "count", 0);
    a.stride = count_in(view, "byteStride", 0);
    if (a.stride == 0) a.stride = a.size * components;
    const std::size_t last = a.size * components;
    if (a.count > 0 && (last > a.bytes.size() || a.stride < last || (a.count - 1) > (a.bytes.size() - last) / a.stride))
      refuse("an accessor reaches beyond its view");
    if (const Value* normalized = member_of(accessor, "normalized"); normalized && normalized->boolean())
      a.normalized = *normalized->boolean();
    return a;
  }

  static Affine placement(const Value& node) {
    if (const std::vector<double> m = numbers_in(&node, "matrix", 16); !m.empty()) {
      Affine a;
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) a.m[i][j] = m[4 * j + i];
        a.t[i] = m[12 + i];
      }
      return a;
    }
    Affine a;
    if (const auto t = numbers_in(&node, "translation", 3); !t.empty()) a = translation({t[0], t[1], t[2]});
    if (const auto r = numbers_in(&node, "rotation", 4); !r.empty()) {
      const double length = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
      if (!(length > 1e-9) || !std::isfinite(length)) refuse("a rotation has no direction");
      a = a * rotation({r[3] / length, r[0] / length, r[1] / length, r[2] / length});
    }
    if (const auto s = numbers_in(&node, "scale", 3); !s.empty()) a = a * scaling({s[0], s[1], s[2]});
    return a;
  }

  void read_node(std::size_t index, const Affine& parent, bool wanted, int depth) {
    const Value* node = item("nodes", index);
    if (!node) refuse("a node does not exist");
    if (depth > 64 || visited_[index]) refuse("its nodes are nested too deeply, or one has several parents");
    visited_[index] = true;
    const Affine at = parent * placement(*node);
    wanted = wanted || string_in(node, "name") == submesh_;
    if (const std::size_t own = count_in(node, "mesh", no_index); own != no_index) read_mesh(own, at, wanted);
    for (const std::size_t child : indices_in(node, "children")) read_node(child, at, wanted, depth + 1);
  }

  void read_mesh(std::size_t index, const Affine& at, bool wanted) {
    const Value* mesh = item("meshes", index);
    if (!mesh) refuse("a mesh does not exist");
    const Value* primitives = member_of(mesh, "primitives");
    if (!(wanted || string_in(mesh, "name") == submesh_) || !primitives || !primitives->array()) return;
    for (const Value& each : *primitives->array()) {
      if (++primitives_ > 1'000'000) refuse("it has more than a million parts");
      const std::size_t mode = count_in(&each, "mode", 4);
      const std::size_t positions = count_in(member_of(&each, "attributes"), "POSITION", no_index);
      if (mode < 4 || mode > 6 || positions == no_index) continue;  // points and lines
      MeshPart part;
      part.colour = colour_of(each);
      const Accessor points = accessor_of(positions, 3);
      points_ += points.count;
      if (points_ > 3 * most_mesh_triangles) refuse("it has more than 12 million points", "simplify it");
      for (std::size_t i = 0; i < points.count; ++i)
        part.points.push_back(at({points.component(i, 0), points.component(i, 1), points.component(i, 2)}));
      const std::size_t indices = count_in(&each, "indices", no_index);
      const Accessor corners = indices == no_index ? Accessor{} : accessor_of(indices, 1);
      read_triangles(
          mode, indices == no_index ? points.count : corners.count,
          [&](std::size_t i) { return indices == no_index ? i : static_cast<std::size_t>(corners.component(i, 0)); },
          at.mirrors(), part);
      triangles_ += part.triangles.size();
      if (triangles_ > most_mesh_triangles) refuse("it has more than 4 million triangles", "simplify it");
      mesh_.parts.push_back(std::move(part));
    }
  }

  // Mode 4: separate triangles, 5: a strip, 6: a fan.
  template <class Corner>
  static void read_triangles(std::size_t mode, std::size_t count, const Corner& corner, bool mirrored, MeshPart& part) {
    for (std::size_t k = 2; k < count; k += mode == 4 ? 3 : 1) {
      std::size_t a = corner(mode == 6 ? 0 : k - 2), b = corner(k - 1);
      if (mirrored != (mode == 5 && k % 2 == 1)) std::swap(a, b);
      add_triangle(part, a, b, corner(k));
    }
  }

  std::string colour_of(const Value& primitive) const {
    const Value* material = item("materials", count_in(&primitive, "material", no_index));
    const Value* metallic = member_of(material, "pbrMetallicRoughness");
    const std::vector<double> c = numbers_in(metallic, "baseColorFactor", 4);
    if (c.empty()) return metallic ? "#ffffff" : "";
    const auto shown = [](double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; };  // as sRGB
    return colour_text({shown(c[0]), shown(c[1]), shown(c[2])});
  }

  const Value& document_;
  const std::string& submesh_;
  std::deque<std::string> owned_;  // a deque: views of its strings stay valid
  std::vector<std::string_view> buffers_;
  std::vector<bool> visited_;  // nodes
  std::size_t primitives_ = 0, points_ = 0, triangles_ = 0;
  Mesh mesh_;
};

}  // namespace

Mesh read_gltf(std::string_view content, const std::string& submesh, const CompanionFiles& companions) {
  std::string_view json = content, binary;
  if (content.substr(0, 4) == "glTF") {  // a header of 12 bytes, then chunks: length, type, content
    if (content.size() < 20 || little_endian<std::uint32_t>(content, 4) != 2) refuse("it is not of version 2 of the format");
    const std::size_t length = little_endian<std::uint32_t>(content, 12);
    if (length > content.size() - 20) refuse("it ends before its document does");
    json = content.substr(20, length);
    if (const std::size_t next = 20 + (length + 3) / 4 * 4; next + 8 <= content.size()) {
      const std::size_t size = little_endian<std::uint32_t>(content, next);
      if (size > content.size() - next - 8) refuse("it ends before its buffer does");
      binary = content.substr(next + 8, size);
    }
  }
  if (std::count(json.begin(), json.end(), ',') > 5'000'000) refuse("its document has more than five million values");
  const Value document = parse_json(json, "");
  return Gltf(document, binary, submesh, companions).read();
}

}  // namespace momentree::io::mesh
