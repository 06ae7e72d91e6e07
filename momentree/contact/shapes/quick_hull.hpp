#pragma once
// The convex hull of points in space.
#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <momentree/math/vec.hpp>

namespace momentree::contact {

/// Triangles of a hull, as indices of points, counterclockwise seen from outside.
struct Hull {
  std::vector<std::array<int, 3>> triangles;  ///< none if the points lie in a plane
  double beyond = 0;                          ///< how far above its triangles other points are (m)
};

/// Points are added one by one, the farthest first, until no other one is farther outside than `tolerance` times the size of the
/// whole, or the hull has `most` corners.
Hull quick_hull(std::span<const Vec3> points, double tolerance = 1e-12,
                std::size_t most = std::numeric_limits<std::size_t>::max());

}  // namespace momentree::contact
