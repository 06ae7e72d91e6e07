#include <momentree/models/mesh/pack.hpp>

#include <algorithm>
#include <cmath>
#include <new>

#include <momentree/models/mesh/read_mesh.hpp>
#include <momentree/models/mesh/simplify.hpp>
#include <momentree/text/base64.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

namespace {

constexpr std::size_t most_of_one_part = 20'000;  // triangles: indices of their corners fit into 16 bits
constexpr std::size_t least_of_one_part = 60;
constexpr std::size_t most_to_simplify = 100'000;  // triangles: more are merged on a grid first, which is faster
constexpr std::size_t most_of_all = 8'000'000;     // triangles in all files together
constexpr std::size_t most_sources = 1000, most_parts = 32;

struct Packed {
  Mesh mesh;
  std::size_t triangles = 0;  ///< in the file
  bool readable = false;
};

/// Parts of the same colour are one.
void join_colours(Mesh& mesh) {
  std::vector<MeshPart> joined;
  for (MeshPart& part : mesh.parts) {
    auto same = std::find_if(joined.begin(), joined.end(), [&](const MeshPart& each) { return each.colour == part.colour; });
    if (same == joined.end() && joined.size() >= most_parts) same = joined.end() - 1;  // and colours beyond any number in use
    if (same == joined.end()) {
      joined.push_back(std::move(part));
      continue;
    }
    const auto first = static_cast<std::uint32_t>(same->points.size());
    same->points.insert(same->points.end(), part.points.begin(), part.points.end());
    for (const auto& [a, b, c] : part.triangles) same->triangles.push_back({first + a, first + b, first + c});
  }
  mesh.parts = std::move(joined);
}

Packed read_packed(const MeshSource& source) {
  Packed packed;
  packed.mesh = source.path.empty() ? Mesh{{source.inside}} : read_mesh_file(source.path, source.submesh);
  packed.triangles = packed.mesh.triangles();
  for (MeshPart& part : packed.mesh.parts)
    if (part.colour.empty()) part.colour = source.colour;
  join_colours(packed.mesh);
  for (MeshPart& part : packed.mesh.parts) {
    merge_points(part, 65535);
    for (double cells = 2048; part.triangles.size() > most_to_simplify && cells >= 1; cells /= 2) merge_points(part, cells);
    simplify(part, most_of_one_part);
  }
  std::erase_if(packed.mesh.parts, [](const MeshPart& part) { return part.triangles.empty(); });
  packed.readable = true;
  return packed;
}

/// The largest number of triangles per part for which all of them together have at most `most`.
std::size_t largest_part(std::vector<std::size_t> sizes, std::size_t most) {
  std::sort(sizes.begin(), sizes.end());
  for (std::size_t i = 0, below = 0; i < sizes.size(); below += sizes[i++])
    if (const std::size_t left = sizes.size() - i; below + sizes[i] * left > most)
      return std::max(below < most ? (most - below) / left : 0, least_of_one_part);
  return most_of_one_part;
}

void write_part(JsonWriter& json, const MeshPart& part) {
  Vec3 low = part.points.front(), high = low;
  for (const Vec3& p : part.points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  std::vector<unsigned char> points, triangles;
  const auto put = [](std::vector<unsigned char>& bytes, std::uint32_t number) {
    bytes.push_back(static_cast<unsigned char>(number & 255));
    bytes.push_back(static_cast<unsigned char>(number >> 8));
  };
  const auto level = [](double x, double from, double to) {
    return to > from ? static_cast<std::uint32_t>(std::lround(65535 * (x - from) / (to - from))) : 0u;
  };
  for (const Vec3& p : part.points) {
    put(points, level(p.x, low.x, high.x));
    put(points, level(p.y, low.y, high.y));
    put(points, level(p.z, low.z, high.z));
  }
  for (const auto& triangle : part.triangles)
    for (const std::uint32_t corner : triangle) put(triangles, corner);
  json.begin_object();
  if (!part.colour.empty()) json.member("colour", part.colour);
  json.member("low", low).member("high", high);
  std::string text;
  append_base64(text, points);
  json.member("points", text);
  text.clear();
  append_base64(text, triangles);
  json.member("triangles", text).end_object();
}

}  // namespace

PackedMeshes pack_meshes(const MeshSources& sources, std::size_t most) {
  PackedMeshes result;
  if (sources.empty()) return result;
  std::vector<Packed> all(sources.size());
  const auto warn = [&](const MeshSource& source, std::string what, std::string hint) {
    result.warnings.push_back({Severity::warning, source.file, source.place.line, source.place.column, std::move(what),
                               hint.empty() ? "the motion does not depend on it" : std::move(hint), ""});
  };
  std::size_t triangles = 0;
  for (std::size_t i = 0; i < sources.size() && i < most_sources; ++i) {
    if (triangles > most_of_all) {
      warn(*sources[i], "this mesh and those after it are not drawn: the others have more than 8 million triangles",
           "simplify them");
      break;
    }
    const MeshSource& source = *sources[i];
    const std::string name = source.path.empty() ? "a mesh" : "the mesh " + in_quotes(source.path);
    try {
      all[i] = read_packed(source);
      triangles += all[i].triangles;
    } catch (const Error& error) {
      const std::string line = error.where.empty() ? "" : error.where.substr(error.where.find_first_not_of(':')) + ": ";
      warn(source, name + " is not drawn: " + line + error.problem, error.hint);
    } catch (const std::bad_alloc&) {
      warn(source, name + " is not drawn: out of memory", "");
    }
  }
  if (sources.size() > most_sources)
    warn(*sources[most_sources], "meshes after the first " + std::to_string(most_sources) + " are not drawn", "");

  std::vector<std::size_t> sizes;
  for (const Packed& each : all)
    for (const MeshPart& part : each.mesh.parts) sizes.push_back(part.triangles.size());
  const std::size_t largest = largest_part(sizes, most);
  JsonWriter json(result.json, 1);
  json.begin_array();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].readable) {
      json.null();
      continue;
    }
    json.begin_object().member("triangles", static_cast<long>(all[i].triangles)).key("parts").begin_array();
    for (MeshPart& part : all[i].mesh.parts) {
      simplify(part, largest);
      write_part(json, part);
    }
    json.end_array().end_object();
  }
  json.end_array();
  return result;
}

PackedMeshes meshes_json(const MeshSources& sources) {
  PackedMeshes packed = pack_meshes(sources);
  if (!packed.json.empty()) packed.json = "{\"format\": 1, \"meshes\": " + packed.json + "}\n";
  return packed;
}

}  // namespace momentree::io
