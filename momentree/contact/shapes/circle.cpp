#include <momentree/contact/shapes/circle.hpp>

#include <algorithm>
#include <cmath>

namespace momentree::contact {

namespace {

constexpr int most_halvings = 60;
constexpr double seen_round = 1e-9;  // sine of the angle between a line and an axis: the circle is seen as a circle

struct OnEllipse {
  double cosine, sine;
};

// The point (a cos, b sin) of an ellipse with a ≥ b ≥ 0 that is nearest to a point of the first quadrant (D. Eberly, Distance
// from a point to an ellipse).
OnEllipse on_ellipse(double a, double b, double x, double y) {
  if (!(b > 0)) {
    const double cosine = std::min(1.0, x / a);
    return {cosine, std::sqrt(1 - cosine * cosine)};
  }
  if (!(y > 0)) {
    const double cosine = a * x < (a - b) * (a + b) ? a * x / ((a - b) * (a + b)) : 1.0;
    return {cosine, std::sqrt(1 - cosine * cosine)};
  }
  const double zx = x / a, zy = y / b, ratio = (a / b) * (a / b);
  if (zx * zx + zy * zy == 1) return {zx, zy};
  // (ratio zx/(s + ratio))² + (zy/(s + 1))² = 1: a convex decreasing function of s.
  double low = zy - 1, high = std::hypot(ratio * zx, zy) - 1, s = std::max(low, 0.0);
  if (zx * zx + zy * zy < 1) high = std::min(high, 0.0), s = low;
  for (int k = 0; k < most_halvings; ++k) {
    const double p = ratio * zx / (s + ratio), q = zy / (s + 1), value = p * p + q * q - 1;
    (value > 0 ? low : high) = s;
    const double slope = -2 * (p * p / (s + ratio) + q * q / (s + 1));
    double next = s - value / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::fabs(next - s) <= 1e-15 * (1 + std::fabs(s))) break;
    s = next;
  }
  const double p = ratio * zx / (s + ratio), q = zy / (s + 1), size = std::hypot(p, q);
  return {p / size, q / size};
}

}  // namespace

OnCircle nearest_to_line(const Vec3& from, const Vec3& axis, double rim, const Vec3& line, bool ahead) noexcept {
  const Vec3 apart = from - dot(from, line) * line;  // perpendicular to the line, to the centre
  const double along = dot(axis, line);
  const Vec3 rise = axis - along * line, level = cross(line, axis);
  const double sine = norm(level);
  OnCircle found;
  if (sine < seen_round) {
    found.radial = -(apart - dot(apart, axis) * axis);
    if (!(norm(found.radial) > 0)) return found;
    found.radial = normalized(found.radial);
  } else {
    const Vec3 u = (1 / sine) * level, w = cross(axis, u);
    const double x = -dot(apart, u), y = -dot(apart, rise) / sine, b = std::fabs(along) * rim;
    OnEllipse at{};
    if (ahead && y < 0) {
      if (!(std::fabs(x) < rim)) return found;
      at.cosine = x / rim, at.sine = std::sqrt(1 - at.cosine * at.cosine);
    } else {
      at = on_ellipse(rim, b, std::fabs(x), std::fabs(y));
      if (x < 0) at.cosine = -at.cosine;
      if (y < 0) at.sine = -at.sine;
    }
    found.radial = at.cosine * u + (along < 0 ? at.sine : -at.sine) * w;
  }
  // To rounding: the vector from the line to the point is perpendicular to what is seen of the tangent.
  for (int k = 0; k < 20; ++k) {
    const Vec3 tangent = cross(axis, found.radial), d = apart + rim * found.radial;
    const double t = dot(tangent, line), curvature = dot(found.radial, d) - dot(found.radial, line) * dot(d, line);
    const double residual = dot(d, tangent) - dot(d, line) * t, slope = rim * (1 - t * t) - curvature;
    if (!(slope > 0)) return found;
    const double turn = std::clamp(-residual / slope, -0.5, 0.5);
    found.radial = normalized(turned(found.radial, tangent, turn));
    if (std::fabs(turn) < 1e-15) break;
  }
  found.found = true;
  return found;
}

void circle_before_line(const Features& f, const Place& a, const Place& b, Touch& out, Vec3& rate) noexcept {
  const Vec3 axis = a.R * f.line_a, line = b.R * f.line_b, line_rate = cross(b.w, line);
  const Vec3 centre = a.r + a.R * f.point_a, on_line = b.r + b.R * f.point_b;
  OnCircle at = nearest_to_line(centre - on_line, axis, f.rim, line, f.side > 0);
  if (!(norm(at.radial) > 0)) perpendiculars(axis, out.tangent), at.radial = out.tangent[0];
  const Vec3 &radial = at.radial, tangent = cross(axis, radial), d = centre + f.rim * radial - on_line;
  out.point = centre + f.rim * radial;
  // Rates of what turns with the body of the circle, and then of the angle at which the point is.
  const Vec3 tangent_rate = cross(a.w, tangent);
  const Vec3 d_rate = a.v + cross(a.w, out.point - a.r) - b.v - cross(b.w, on_line - b.r);
  const double t = dot(tangent, line), s = dot(d, line);
  const double fixed = dot(d_rate, tangent) + dot(d, tangent_rate) - (dot(d_rate, line) + dot(d, line_rate)) * t -
                       s * (dot(tangent_rate, line) + dot(tangent, line_rate));
  const double slope = f.rim * (1 - t * t) - dot(radial, d) + dot(radial, line) * s;
  const double turning = slope > 0 ? -fixed / slope : 0.0;
  rate = a.v + cross(a.w, out.point - a.r) + (turning * f.rim) * tangent;
  Vec3 normal = cross(line, tangent);
  Vec3 normal_rate = cross(line_rate, tangent) + cross(line, tangent_rate - turning * radial);
  if (dot(normal, radial) > 0) normal = -normal, normal_rate = -normal_rate;
  const double size = norm(normal);
  if (!(size > 0)) {
    out.normal = -radial, out.gap = norm(d);
    return;
  }
  out.normal = (1 / size) * normal;
  out.normal_rate = (1 / size) * (normal_rate - dot(out.normal, normal_rate) * out.normal);
  out.gap = dot(out.normal, d);
}

TwoCircles nearest_of_circles(const Vec3& from, const Vec3& axis_a, double rim_a, const Vec3& axis_b, double rim_b,
                              double side) noexcept {
  TwoCircles found;
  const Vec3 level = cross(axis_a, axis_b);
  const double sine = norm(level);
  if (sine < seen_round) return found;
  // Where the first circle passes through the plane of the second one, or comes nearest to it.
  const Vec3 u = (1 / sine) * level, w = cross(axis_a, u);
  const double s = std::clamp(dot(from, axis_b) / (rim_a * sine), -1.0, 1.0);
  Vec3 &a = found.radial_a, &b = found.radial_b;
  a = std::copysign(std::sqrt(1 - s * s), side) * u + s * w;
  const Vec3 there = from + rim_a * a, flat = there - dot(there, axis_b) * axis_b;
  if (!(norm(flat) > 0)) return found;
  b = normalized(flat);
  for (int k = 0; k < 30; ++k) {
    const Vec3 ta = cross(axis_a, a), tb = cross(axis_b, b), d = from + rim_a * a - rim_b * b;
    const double c = dot(ta, tb), aa = rim_a - dot(d, a), bb = rim_b + dot(d, b), determinant = aa * bb - rim_a * rim_b * c * c;
    if (!(aa > 0 && determinant > 1e-12 * rim_a * rim_b)) return found;
    // d·ta and −d·tb are to vanish, as the square of the distance is least.
    const double fa = dot(d, ta), fb = -dot(d, tb);
    double turn_a = -(bb * fa + rim_b * c * fb) / determinant, turn_b = -(aa * fb + rim_a * c * fa) / determinant;
    const double most = std::max(std::fabs(turn_a), std::fabs(turn_b));
    if (most > 0.3) turn_a *= 0.3 / most, turn_b *= 0.3 / most;
    a = normalized(turned(a, ta, turn_a)), b = normalized(turned(b, tb, turn_b));
    found.found = most < 1e-9;
    if (most < 1e-15) break;
  }
  return found;
}

void circle_before_circle(const Features& f, const Place& a, const Place& b, Touch& out, Vec3& rate) noexcept {
  const Vec3 axis_a = a.R * f.line_a, axis_b = b.R * f.line_b, centre_a = a.r + a.R * f.point_a, centre_b = b.r + b.R * f.point_b;
  const TwoCircles at = nearest_of_circles(centre_a - centre_b, axis_a, f.rim, axis_b, f.length, f.side);
  const Vec3 ta = cross(axis_a, at.radial_a), tb = cross(axis_b, at.radial_b);
  const Vec3 on_a = centre_a + f.rim * at.radial_a, on_b = centre_b + f.length * at.radial_b, d = on_a - on_b;
  const Vec3 va = a.v + cross(a.w, on_a - a.r), vb = b.v + cross(b.w, on_b - b.r);
  const double c = dot(ta, tb), aa = f.rim - dot(d, at.radial_a), bb = f.length + dot(d, at.radial_b);
  const double determinant = aa * bb - f.rim * f.length * c * c;
  const double fa = dot(va - vb, ta) + dot(d, cross(a.w, ta)), fb = -dot(va - vb, tb) - dot(d, cross(b.w, tb));
  const bool regular = determinant > 0;
  const double turning_a = regular ? -(bb * fa + f.length * c * fb) / determinant : 0.0;
  const double turning_b = regular ? -(aa * fb + f.rim * c * fa) / determinant : 0.0;
  const Vec3 ta_rate = cross(a.w, ta) - turning_a * at.radial_a, tb_rate = cross(b.w, tb) - turning_b * at.radial_b;
  out.point = on_a, rate = va + (turning_a * f.rim) * ta;
  Vec3 normal = cross(ta, tb), normal_rate = cross(ta_rate, tb) + cross(ta, tb_rate);
  if (dot(normal, at.radial_b + axis_b - at.radial_a - axis_a) < 0) normal = -normal, normal_rate = -normal_rate;
  const double size = norm(normal);
  if (!(size > 0)) {
    out.normal = axis_b, out.gap = norm(d);
    return;
  }
  out.normal = (1 / size) * normal;
  out.normal_rate = (1 / size) * (normal_rate - dot(out.normal, normal_rate) * out.normal);
  out.gap = dot(out.normal, d);
}

}  // namespace momentree::contact
