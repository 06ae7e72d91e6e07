#pragma once
// Triangle meshes, for pictures and for what bodies touch with.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <momentree/math/vec.hpp>

namespace momentree::io {

/// Triangles of one colour.
struct MeshPart {
  std::string colour{};                                   ///< "#rrggbb"; empty: none is given
  std::vector<Vec3> points{};                             ///< in the units and axes of the mesh, before its scale
  std::vector<std::array<std::uint32_t, 3>> triangles{};  ///< indices of points
};

struct Mesh {
  std::vector<MeshPart> parts{};
  std::size_t triangles() const {
    std::size_t sum = 0;
    for (const MeshPart& part : parts) sum += part.triangles.size();
    return sum;
  }
};

}  // namespace momentree::io
