#pragma once
// Random meshes, and writers of the formats: independent of the readers under test.
#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include <momentree/models/mesh/mesh.hpp>
#include <momentree/text/base64.hpp>

namespace momentree::io::test {

using Corners = std::array<Vec3, 3>;

/// Numbers that every format can represent exactly.
inline double small_number(std::mt19937& random) { return std::uniform_int_distribution<int>(-512, 512)(random) / 64.0; }

/// Triangles between random points, each point used.
inline MeshPart random_part(std::mt19937& random, std::uint32_t points, std::uint32_t triangles) {
  MeshPart part;
  for (std::uint32_t i = 0; i < points; ++i)
    part.points.push_back({small_number(random), small_number(random), small_number(random)});
  std::uniform_int_distribution<std::uint32_t> any(0, points - 1);
  for (std::uint32_t i = 0; i < triangles; ++i) part.triangles.push_back({any(random), any(random), any(random)});
  return part;
}

inline std::vector<Corners> corners_of(const MeshPart& part) {
  std::vector<Corners> all;
  for (const auto& [a, b, c] : part.triangles) all.push_back({part.points[a], part.points[b], part.points[c]});
  return all;
}

inline std::string text_of(double x) { return std::to_string(x); }
inline std::string text_of(const Vec3& p) { return text_of(p.x) + " " + text_of(p.y) + " " + text_of(p.z); }

template <class T>
void append_number(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}
inline void append_point(std::string& bytes, const Vec3& p) {
  for (const double x : {p.x, p.y, p.z}) append_number(bytes, static_cast<float>(x));
}

inline std::string text_stl(const MeshPart& part) {
  std::string text = "solid part\n";
  for (const Corners& t : corners_of(part)) {
    text += "  facet normal 0 0 1\n    outer loop\n";
    for (const Vec3& p : t) text += "      vertex " + text_of(p) + "\n";
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid part\n";
}

/// Begins like the text form, as some programs write it.
inline std::string binary_stl(const MeshPart& part) {
  std::string bytes = "solid binary";
  bytes.resize(80);
  append_number(bytes, static_cast<std::uint32_t>(part.triangles.size()));
  for (const Corners& t : corners_of(part)) {
    append_point(bytes, {0, 0, 1});
    for (const Vec3& p : t) append_point(bytes, p);
    bytes.append(2, '\0');
  }
  return bytes;
}

inline std::string obj(const MeshPart& part, const std::string& material = "") {
  std::string text = "# a mesh\nmtllib m.mtl\no part\n";
  for (const Vec3& p : part.points) text += "v " + text_of(p) + "\n";
  if (!material.empty()) text += "usemtl " + material + "\n";
  bool negative = false;
  for (const auto& t : part.triangles) {
    text += "f";
    for (const std::uint32_t i : t)
      text += negative ? " " + std::to_string(static_cast<long>(i) - static_cast<long>(part.points.size()))
                       : " " + std::to_string(i + 1) + "/7/9";
    text += "\n";
    negative = !negative;
  }
  return text;
}

inline std::string collada(const MeshPart& part, const std::string& node, const std::string& asset = "") {
  std::string numbers, indices;
  for (const Vec3& p : part.points) numbers += text_of(p) + " ";
  for (const auto& t : part.triangles)
    for (const std::uint32_t i : t) indices += "0 " + std::to_string(i) + " ";
  return "<COLLADA><asset>" + asset +
         "</asset><library_effects><effect id='e'><profile_COMMON><technique sid='t'><phong><diffuse><color>1 0.5 0 1</color>"
         "</diffuse></phong></technique></profile_COMMON></effect></library_effects><library_materials><material id='m'>"
         "<instance_effect url='#e'/></material></library_materials><library_geometries><geometry id='g' name='part'><mesh>"
         "<source id='s'><float_array id='f' count='" +
         std::to_string(3 * part.points.size()) + "'>" + numbers +
         "</float_array><technique_common><accessor source='#f' stride='3'/></technique_common></source><vertices id='v'><input "
         "semantic='POSITION' source='#s'/></vertices><triangles material='sym' count='" +
         std::to_string(part.triangles.size()) +
         "'><input semantic='NORMAL' source='#n' offset='0'/><input semantic='VERTEX' source='#v' offset='1'/><p>" + indices +
         "</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id='scene'>" + node +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#scene'/></scene></COLLADA>";
}
inline std::string instance() {
  return "<instance_geometry url='#g'><bind_material><technique_common><instance_material symbol='sym' target='#m'/>"
         "</technique_common></bind_material></instance_geometry>";
}

/// The document, and the bytes of its buffer: positions, then indices.
struct GltfParts {
  std::string json, buffer;
};
inline GltfParts gltf_parts(const MeshPart& part, const std::string& node, const std::string& buffer_member) {
  GltfParts parts;
  for (const Vec3& p : part.points) append_point(parts.buffer, p);
  const std::size_t points = parts.buffer.size();
  for (const auto& t : part.triangles)
    for (const std::uint32_t i : t) append_number(parts.buffer, static_cast<std::uint16_t>(i));
  const auto number = [](std::size_t n) { return std::to_string(n); };
  parts.json =
      R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [)" + node +
      R"(], "meshes": [{"name": "part", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],)" +
      R"("materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0.21586, 1]}}], "accessors": [)" +
      R"({"bufferView": 0, "componentType": 5126, "count": )" + number(part.points.size()) +
      R"(, "type": "VEC3"}, {"bufferView": 1, "componentType": 5123, "count": )" + number(3 * part.triangles.size()) +
      R"(, "type": "SCALAR"}], "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": )" + number(points) +
      R"(}, {"buffer": 0, "byteOffset": )" + number(points) + R"(, "byteLength": )" + number(parts.buffer.size() - points) +
      R"(}], "buffers": [{)" + buffer_member + R"("byteLength": )" + number(parts.buffer.size()) + "}]}";
  return parts;
}
inline std::string gltf(const MeshPart& part, const std::string& node = R"({"mesh": 0})") {
  const GltfParts parts = gltf_parts(part, node, "");
  std::string text;
  append_base64(text, {reinterpret_cast<const unsigned char*>(parts.buffer.data()), parts.buffer.size()});
  return gltf_parts(part, node, "\"uri\": \"data:application/octet-stream;base64," + text + "\", ").json;
}
inline std::string glb(const MeshPart& part, const std::string& node = R"({"mesh": 0})") {
  GltfParts parts = gltf_parts(part, node, "");
  parts.json.resize((parts.json.size() + 3) / 4 * 4, ' ');
  parts.buffer.resize((parts.buffer.size() + 3) / 4 * 4);
  std::string bytes = "glTF";
  append_number(bytes, std::uint32_t{2});
  append_number(bytes, static_cast<std::uint32_t>(28 + parts.json.size() + parts.buffer.size()));
  append_number(bytes, static_cast<std::uint32_t>(parts.json.size()));
  bytes += "JSON" + parts.json;
  append_number(bytes, static_cast<std::uint32_t>(parts.buffer.size()));
  bytes += std::string("BIN\0", 4) + parts.buffer;
  return bytes;
}

}  // namespace momentree::io::test
