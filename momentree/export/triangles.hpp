#pragma once
// Triangles of solids, with normals that point outwards; single precision.
#include <cstdint>
#include <vector>

#include <momentree/models/mesh/mesh.hpp>

namespace momentree::io {

struct Triangles {
  std::vector<float> positions{}, normals{};  ///< x, y, z per point (m); no normals: flat triangles
  std::vector<std::uint32_t> indices{};       ///< three points per triangle, anticlockwise seen from outside
};

Triangles unit_box();       ///< edges of length 1, centred
Triangles unit_sphere();    ///< diameter 1
Triangles unit_cylinder();  ///< diameter and length 1, along z, centred
/// Along z, centred; `length` between the centres of its caps (m).
Triangles capsule_of(double radius, double length);
Triangles triangles_of(const MeshPart& part);

}  // namespace momentree::io
