// Any bytes are either a mesh with valid indices and finite points, which can be packed, or refused with an Error. The first byte
// gives the format.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include <momentree/base/error.hpp>
#include <momentree/models/mesh/read_mesh.hpp>
#include <momentree/models/mesh/simplify.hpp>

using namespace momentree;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr const char* names[] = {"a.stl", "a.obj", "a.dae", "a.gltf", "a.glb"};
  const std::string_view content(reinterpret_cast<const char*>(data) + 1, size - 1);
  io::Mesh mesh;
  try {
    mesh = io::read_mesh_text(content, names[data[0] % 5]);
  } catch (const Error&) {
    return 0;
  }
  for (io::MeshPart& part : mesh.parts) {
    io::merge_points(part, 65535);
    io::simplify(part, 60);
    if (part.triangles.size() > 60) std::abort();
    for (const auto& triangle : part.triangles)
      for (const std::uint32_t corner : triangle)
        if (corner >= part.points.size() || !std::isfinite(norm(part.points[corner]))) std::abort();
  }
  return 0;
}
