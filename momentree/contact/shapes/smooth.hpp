#pragma once
// Smooth convex surfaces by their support functions, about their centres.
#include <array>
#include <vector>

#include <momentree/math/vec.hpp>

namespace momentree::contact {

/// The sizes of a smooth solid along its axes (m): of an ellipsoid its semi-axes.
using Axes = std::array<Vec3, 3>;

struct SmoothSurface {
  Vec3 (*farthest)(const Axes& axes, const Vec3& n) = nullptr;  ///< the point farthest along a unit vector
  /// How that point moves as n turns: perpendicular to n, symmetric and not negative.
  Vec3 (*farthest_rate)(const Axes& axes, const Vec3& n, const Vec3& n_rate) = nullptr;
};
/// Unit vectors in all directions, so many of them around z.
std::vector<Vec3> directions(int around);
/// The surface of a primitive by its number; null for 0, an ellipsoid.
const SmoothSurface* smooth_surface(unsigned char number) noexcept;

}  // namespace momentree::contact
