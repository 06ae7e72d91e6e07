#pragma once
// The points of circles, such as the rims of cylinders, that are nearest to lines and to each other.
#include <momentree/contact/shapes/feature.hpp>

namespace momentree::contact {

/// The direction from the centre of a circle to its point nearest to a line.
struct OnCircle {
  Vec3 radial{};
  bool found = false;
};
/// `from`: from any point of the line to the centre (m). `ahead`: on the half of the circle that is ahead along the axis as seen
/// along the line, also if the line is before the other half. Seen along the line the circle is an ellipse.
OnCircle nearest_to_line(const Vec3& from, const Vec3& axis, double rim, const Vec3& line, bool ahead) noexcept;

/// Gap, normal and point of FeaturePair::circle_line, without rounding; `rate`: of the point.
void circle_before_line(const Features& features, const Place& a, const Place& b, Touch& out, Vec3& rate) noexcept;

/// The directions from the centres of two circles to the points at which they are nearest.
struct TwoCircles {
  Vec3 radial_a{}, radial_b{};
  bool found = false;
};
/// `from`: from the centre of b to that of a (m). Near the point at which circle a passes through the plane of b, with `side` the
/// sign of its direction along axis_a × axis_b.
TwoCircles nearest_of_circles(const Vec3& from, const Vec3& axis_a, double rim_a, const Vec3& axis_b, double rim_b,
                              double side) noexcept;

/// The same as circle_before_line for a circle of body b, of radius `length`.
void circle_before_circle(const Features& features, const Place& a, const Place& b, Touch& out, Vec3& rate) noexcept;

}  // namespace momentree::contact
