#include <momentree/models/mesh/read_mesh.hpp>

#include <algorithm>
#include <filesystem>

#include <momentree/models/mesh/formats.hpp>
#include <momentree/text/files/file_name.hpp>
#include <momentree/text/files/input_file.hpp>

namespace momentree::io {

namespace {

namespace fs = std::filesystem;

std::string ending_of(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  std::string ending(dot == std::string_view::npos ? "" : name.substr(dot + 1));
  std::transform(ending.begin(), ending.end(), ending.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  return ending;
}

bool is_finite(const Vec3& p) {
  constexpr double largest = 1e12;  // sums of squares stay far from the limits of doubles
  return std::fabs(p.x) <= largest && std::fabs(p.y) <= largest && std::fabs(p.z) <= largest;
}

}  // namespace

bool is_mesh_name(std::string_view name) {
  const std::string ending = ending_of(name);
  return ending == "stl" || ending == "obj" || ending == "dae" || ending == "gltf" || ending == "glb";
}

Mesh read_mesh_text(std::string_view content, const std::string& name, const std::string& submesh,
                    const CompanionFiles& companions) {
  const std::string ending = ending_of(name);
  Mesh read;
  if (ending == "stl")
    read = mesh::read_stl(content);
  else if (ending == "obj")
    read = mesh::read_obj(content, submesh, companions);
  else if (ending == "dae")
    read = mesh::read_collada(content, submesh);
  else if (ending == "gltf" || ending == "glb")
    read = mesh::read_gltf(content, submesh, companions);
  else
    mesh::refuse("its format is not known", "convert it to STL, OBJ, Collada or glTF");
  std::erase_if(read.parts, [](const MeshPart& part) { return part.triangles.empty(); });
  if (read.parts.empty()) mesh::refuse(submesh.empty() ? "it has no triangles" : "it has no triangles in a part of that name");
  if (read.triangles() > most_mesh_triangles) mesh::refuse("it has more than 4 million triangles", "simplify it");
  for (const MeshPart& part : read.parts)
    if (!std::all_of(part.points.begin(), part.points.end(), is_finite))
      mesh::refuse("a coordinate is not a finite number, or larger than 1e12");
  return read;
}

Mesh read_mesh_file(const std::string& path, const std::string& submesh) {
  std::string content;
  Unreadable why;
  if (!read_whole_file(path, "mesh", largest_mesh_file, content, why)) mesh::refuse("it " + why.what, why.hint);
  const Enclosure enclosure(path);
  std::size_t left = largest_mesh_file;  // bytes of all companions
  const auto companion = [&](const std::string& name) -> std::optional<std::string> {
    const fs::path file = fs::path(path).parent_path() / name;
    std::string text;
    Unreadable ignored;
    if (name.empty() || leaves_folder(name) || !enclosure.holds(file)) return {};
    if (!read_whole_file(file.string(), "mesh", left, text, ignored)) return {};
    left -= text.size();
    return text;
  };
  return read_mesh_text(content, path, submesh, companion);
}

}  // namespace momentree::io
