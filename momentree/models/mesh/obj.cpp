// Wavefront OBJ: points, polygons, and colours from its material files.
#include <algorithm>
#include <unordered_map>

#include <momentree/models/import/shape.hpp>
#include <momentree/models/mesh/formats.hpp>

namespace momentree::io::mesh {

namespace {

using ObjColours = std::unordered_map<std::string, std::string>;

std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

/// The rest of a line after its first word, without surrounding blanks.
std::string rest_of(std::string_view line, std::string_view word) {
  line.remove_prefix(static_cast<std::size_t>(word.data() - line.data()) + word.size());
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!line.empty() && blank(line.front())) line.remove_prefix(1);
  while (!line.empty() && blank(line.back())) line.remove_suffix(1);
  return std::string(line);
}

void read_materials(std::string_view text, ObjColours& colours) {
  std::string name;
  while (!text.empty()) {
    const std::string_view line = next_line(text);
    Words words(line);
    const std::string_view key = words.word();
    if (key == "newmtl") name = rest_of(line, key);
    if (key != "Kd" || Words(rest_of(line, key)).word() == "spectral") continue;
    const Vec3 rgb = words.vec3();
    colours[name] = colour_text({rgb.x, rgb.y, rgb.z});
  }
}

/// The index of a point in `3`, `3/1/2` or `-1` (the last one).
std::uint64_t point_index(std::string_view word, std::size_t points) {
  std::int64_t index = 0;
  const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  const bool ends = rest == word.data() + word.size() || *rest == '/';
  if (error != std::errc{} || !ends || index == 0) refuse("a face has a vertex that is not a number");
  if (index > 0) return static_cast<std::uint64_t>(index - 1);
  const auto back = static_cast<std::uint64_t>(-(index + 1)) + 1;
  return back <= points ? points - back : points;
}

}  // namespace

Mesh read_obj(std::string_view content, const std::string& submesh, const CompanionFiles& companions) {
  std::vector<Vec3> points;
  struct Faces {
    std::string material;
    std::vector<std::array<std::uint64_t, 3>> triangles;
  };
  std::vector<Faces> groups(1);
  std::unordered_map<std::string, std::size_t> group_of{{"", 0}};
  std::size_t group = 0, triangles = 0;
  ObjColours colours;
  bool wanted = submesh.empty();
  while (!content.empty()) {
    const std::string_view line = next_line(content);
    Words words(line);
    const std::string_view key = words.word();
    if (key == "v") {
      points.push_back(words.vec3());
    } else if (key == "o" || key == "g") {
      wanted = submesh.empty() || rest_of(line, key) == submesh;
    } else if (key == "usemtl") {
      const auto [found, fresh] = group_of.emplace(rest_of(line, key), groups.size());
      group = found->second;
      if (fresh) groups.push_back({found->first, {}});
    } else if (key == "mtllib" && companions) {
      if (const auto text = companions(rest_of(line, key))) read_materials(*text, colours);
    } else if (key == "f" && wanted) {
      std::uint64_t first = 0, last = 0, n = 0;
      for (std::string_view word = words.word(); !word.empty(); word = words.word(), ++n) {
        const std::uint64_t index = point_index(word, points.size());
        if (n >= 2) groups[group].triangles.push_back({first, last, index}), ++triangles;
        if (n == 0) first = index;
        last = index;
      }
      if (n < 3) refuse("a face has fewer than three vertices");
      if (triangles > most_mesh_triangles) refuse("it has more than 4 million triangles", "simplify it");
    }
  }
  Mesh mesh;
  for (const Faces& faces : groups) {
    if (faces.triangles.empty()) continue;
    MeshPart part;
    if (const auto colour = colours.find(faces.material); colour != colours.end()) part.colour = colour->second;
    std::unordered_map<std::uint64_t, std::uint64_t> own;  // points of this part, by their index in the file
    const auto index_of = [&](std::uint64_t point) {
      if (point >= points.size()) refuse("a face has a vertex that does not exist");
      const auto [found, fresh] = own.emplace(point, part.points.size());
      if (fresh) part.points.push_back(points[point]);
      return found->second;
    };
    for (const auto& [a, b, c] : faces.triangles) {
      const std::uint64_t i = index_of(a), j = index_of(b);
      add_triangle(part, i, j, index_of(c));
    }
    mesh.parts.push_back(std::move(part));
  }
  return mesh;
}

}  // namespace momentree::io::mesh
