#include <momentree/results/recording/meshes.hpp>

#include <optional>

#include <momentree/results/recording/record.hpp>
#include <momentree/results/recording/recording.hpp>
#include <momentree/text/base64.hpp>
#include <momentree/text/colour.hpp>

namespace momentree::io {

namespace {

/// 16-bit numbers, little-endian, in groups of three; nothing if the text is something else.
std::optional<std::vector<std::uint16_t>> shorts_of(const std::string& text) {
  const std::optional<std::string> bytes = from_base64(text);
  if (!bytes || bytes->size() % 6 != 0) return std::nullopt;
  std::vector<std::uint16_t> numbers;
  for (std::size_t i = 0; i < bytes->size(); i += 2)
    numbers.push_back(static_cast<std::uint16_t>(static_cast<unsigned char>((*bytes)[i]) |
                                                 static_cast<unsigned>(static_cast<unsigned char>((*bytes)[i + 1])) << 8));
  return numbers;
}

MeshPart part_of(const Value& value, Diagnostics& out) {
  Record record(value, "part", out);
  MeshPart part;
  const Vec3 low = record.vec("low"), high = record.vec("high");
  const auto points = shorts_of(record.text("points")), triangles = shorts_of(record.text("triangles"));
  if (!points || !triangles) {
    out.error(value.place, "the points or triangles of a mesh are not numbers in base64", damaged);
    return part;
  }
  if (const Value* colour = record.find("colour"); colour && colour->string()) part.colour = hex_colour(*colour->string());
  for (std::size_t i = 0; i < points->size(); i += 3) {
    const auto between = [&](double from, double to, std::size_t k) { return from + (to - from) * (*points)[i + k] / 65535; };
    part.points.push_back({between(low.x, high.x, 0), between(low.y, high.y, 1), between(low.z, high.z, 2)});
  }
  for (std::size_t i = 0; i < triangles->size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k)
      if ((*triangles)[i + k] >= part.points.size()) {
        out.error(value.place, "a triangle of a mesh has a point that does not exist", damaged);
        return part;
      }
    part.triangles.push_back({(*triangles)[i], (*triangles)[i + 1], (*triangles)[i + 2]});
  }
  return part;
}

}  // namespace

std::vector<MeshParts> read_meshes(const std::filesystem::path& file, std::vector<MeshPart>& parts) {
  std::vector<MeshParts> meshes;
  const std::optional<Value> document = find_document(file);
  if (!document) return meshes;
  Diagnostics out(file.string(), "");
  for (const Value& mesh : Record(*document, "the file", out).list("meshes")) {
    meshes.push_back({parts.size(), 0});
    if (mesh.is_null()) continue;
    for (const Value& part : Record(mesh, "mesh", out).list("parts")) parts.push_back(part_of(part, out));
    meshes.back().count = parts.size() - meshes.back().first;
  }
  out.throw_first();
  return meshes;
}

}  // namespace momentree::io
