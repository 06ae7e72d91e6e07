#pragma once
// Pairs of features of two bodies that can touch, with their gap, the point and the normal of the contact, and how these move.
// Everything is smooth as long as the same features are nearest, and in closed form or solved to rounding.
#include <momentree/contact/shapes/smooth.hpp>
#include <momentree/math/sine_cosine.hpp>

namespace momentree::contact {

/// What touches what. Features are rounded: a sphere is a rounded point, a capsule a rounded line.
enum class FeaturePair : unsigned char {
  point_plane,  ///< a point of body a, a plane of body b
  point_point,
  point_line,  ///< a point of body a, a line of body b
  line_line,
  circle_plane,     ///< the lowest point of a circle of body a, a plane of body b
  point_circle,     ///< a point of body a, a circle of body b
  cable,            ///< two points that are never farther apart than a length
  circle_line,      ///< a circle of body a, a line of body b; or two circles, if there is a `length`
  ellipsoid_plane,  ///< an ellipsoid, or another smooth solid, of body a, a plane of body b
  ellipsoid_line,
  ellipsoids  ///< of body b also a point, which is one without extent; with a `rim`, the circle at the point of b
};

/// Two features, each in the frame of its body.
struct Features {
  FeaturePair pair = FeaturePair::point_plane;
  Vec3 point_a{}, line_a{};           ///< of body a: a point (m), and the unit vector along a line
  Vec3 point_b{}, line_b{};           ///< of body b: a point, and the unit vector along a line or normal to a plane, outward
  double radius_a = 0, radius_b = 0;  ///< m
  /// Of line_line: the sign with which side·(line_a × line_b) points from b to a. Of circle_line: above zero if the line of b is
  /// before the half of the circle ahead along line_a; of two circles, the sign of the nearest point along line_a × line_b.
  double side = 1;
  double rim = 0;                              ///< radius of a circle, whose centre is the point and whose axis is the line (m)
  double length = 0;                           ///< of a cable; of two circles, the radius of that of b (m)
  Axes axes_a{}, axes_b{};                     ///< of smooth solids, whose centres are the points (m)
  unsigned char surface_a = 0, surface_b = 0;  ///< of the same: smooth_surface()
};

/// Pose and velocity of a body's frame, in world axes.
struct Place {
  Mat3 R = identity3<double>();
  Vec3 r{};       ///< its origin (m)
  Vec3 v{}, w{};  ///< velocity of the origin (m/s), angular velocity (rad/s)
};

/// The contact of two features.
struct Touch {
  double gap = 0;        ///< distance of the surfaces; negative: they overlap (m). Of a cable: by how much it is slack
  Vec3 point{};          ///< where they are nearest (m), on the surface of a
  Vec3 normal{};         ///< unit vector from b to a; of a cable, from a to b
  Vec3 tangent[2] = {};  ///< unit vectors, perpendicular to it
  Vec3 point_rate{}, normal_rate{};
};

/// At the places of both bodies; for the ground a default Place.
Touch touch(const Features& features, const Place& a, const Place& b) noexcept;

/// Velocity of the material of a, less that of b, at the contact point.
Vec3 relative_velocity(const Touch& touch, const Place& a, const Place& b) noexcept;

/// Where along its line the nearest point of body a is, from point_a, and that of body b from point_b (m); zero for points.
struct Along {
  double a = 0, b = 0;
};
Along nearest_along(const Features& features, const Place& a, const Place& b) noexcept;

/// Two unit vectors perpendicular to n and to each other.
void perpendiculars(const Vec3& n, Vec3* tangent) noexcept;
/// A vector turned by an angle in the plane of it and one of the same length at right angles to it, towards that.
inline Vec3 turned(const Vec3& from, const Vec3& towards, double angle) noexcept {
  const auto [s, c] = sine_cosine(angle);
  return c * from + s * towards;
}

}  // namespace momentree::contact
