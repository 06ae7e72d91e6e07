#pragma once
// Orthographic views: the direction of view and the projection of points.
#include <span>
#include <string_view>

#include <momentree/math/vec.hpp>

namespace momentree::io {

/// A point of the picture in metres, x to the right, y down.
struct Point2 {
  double x = 0, y = 0;
};

/// A viewer infinitely far away. Three unit vectors, world axes; `right` = `look` × `up`.
struct View {
  Vec3 right{1, 0, 0}, up{0, 1, 0}, look{0, 0, -1};
  Point2 operator()(const Vec3& p) const { return {dot(right, p), -dot(up, p)}; }
  double depth(const Vec3& p) const { return dot(look, p); }  ///< larger is farther away
};

/// The view in the direction `look`, rotated so that gravity points down in the picture; without gravity, or along it, world z,
/// y or x points up. Throws Error if `look` is zero.
View view_along(const Vec3& look, const Vec3& gravity);

/// A view of these points: along the normal of a planar motion; for a spatial one, from 20 degrees above with the widest
/// horizontal spread across the picture. Gravity points down in the picture, except that motion in a horizontal plane is viewed
/// from above.
View choose_view(std::span<const Vec3> points, const Vec3& gravity);

/// Parses a direction such as "0,0,-1". Throws Error.
Vec3 parse_direction(std::string_view text);

}  // namespace momentree::io
