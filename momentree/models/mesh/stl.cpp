// STL: binary (80 bytes, a count, 50 bytes per triangle) or text.
#include <momentree/models/mesh/formats.hpp>

namespace momentree::io::mesh {

namespace {

constexpr std::size_t stl_header = 84, stl_facet = 50;

Mesh read_binary_stl(std::string_view content) {
  const std::uint32_t count = little_endian<std::uint32_t>(content, 80);
  if (count > (content.size() - stl_header) / stl_facet)
    refuse("it ends before the last of its " + std::to_string(count) + " triangles");
  if (count > most_mesh_triangles) refuse("it has more than 4 million triangles", "simplify it");
  MeshPart part;
  part.points.reserve(3 * std::size_t{count});
  for (std::size_t at = stl_header, i = 0; i < count; ++i, at += stl_facet) {
    for (std::size_t k = 0; k < 3; ++k) {  // after the normal
      const auto number = [&](std::size_t n) { return double{little_endian<float>(content, at + 12 * (k + 1) + 4 * n)}; };
      part.points.push_back({number(0), number(1), number(2)});
    }
    const std::uint64_t n = part.points.size();
    add_triangle(part, n - 3, n - 2, n - 1);
  }
  return {{std::move(part)}};
}

Mesh read_text_stl(std::string_view content) {
  MeshPart part;
  Words words(content);
  std::uint64_t of_facet = 0;
  for (std::string_view word = words.word(); !word.empty(); word = words.word()) {
    if (word == "vertex") {
      part.points.push_back(words.vec3());
      if (++of_facet > 3) refuse("a facet has more than three vertices");
    } else if (word == "endfacet") {
      const std::uint64_t n = part.points.size();
      if (of_facet != 3) refuse("a facet has fewer than three vertices");
      add_triangle(part, n - 3, n - 2, n - 1);
      of_facet = 0;
    }
  }
  if (of_facet != 0) refuse("it ends within a facet");
  return {{std::move(part)}};
}

}  // namespace

// Some programs begin binary files with "solid", too: the size decides.
Mesh read_stl(std::string_view content) {
  const bool fits =
      content.size() >= stl_header && (content.size() - stl_header) / stl_facet == little_endian<std::uint32_t>(content, 80);
  if (!fits && content.substr(0, 5) == "solid") return read_text_stl(content);
  if (content.size() < stl_header) refuse("it is too short for an STL file");
  return read_binary_stl(content);
}

}  // namespace momentree::io::mesh
