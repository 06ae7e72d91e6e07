#pragma once
// The outline of a mesh in a picture.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <momentree/export/picture/projection.hpp>

namespace momentree::io {

/// Closed loops around what the triangles cover, one after the other. A point is covered if the loops wind around it, in either
/// direction: `fill-rule="nonzero"` of SVG. Edges that triangles share are not part of it, so that a loop has few points.
/// `points`: in the view plane; `triangles`: indices of points. Triangles of a closed mesh that faces outwards, or of any mesh.
std::vector<std::vector<Point2>> outline_of(std::span<const Point2> points,
                                            std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace momentree::io
