#pragma once
// The points of circles, such as the rims of cylinders, that are nearest to lines.
#include <momentree/contact/feature.hpp>

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

}  // namespace momentree::contact
