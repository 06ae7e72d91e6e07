#pragma once
// Orthographic views: which way the viewer looks, and where a point lies in the picture.
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

/// The view in the direction `look`, turned so that gravity points down in the picture; without gravity, or along it, world z, y
/// or x points up. Throws Error if `look` is zero.
View view_along(const Vec3& look, const Vec3& gravity);

/// A view of these points: along the normal of a planar motion; of a spatial one with the widest horizontal spread across, from
/// 20 degrees above. Gravity points down in the picture, unless the motion lies in a horizontal plane: that is seen from above.
View choose_view(std::span<const Vec3> points, const Vec3& gravity);

/// "0,0,-1" as a direction. Throws Error.
Vec3 parse_direction(std::string_view text);

}  // namespace momentree::io
