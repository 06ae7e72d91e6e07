#include <momentree/contact/shapes/feature.hpp>

#include <cmath>

#include <momentree/contact/shapes/circle.hpp>
#include <momentree/contact/shapes/ellipsoid.hpp>

namespace momentree::contact {

namespace {

Vec3 place_of(const Place& body, const Vec3& point) { return body.r + body.R * point; }
Vec3 velocity_at(const Place& body, const Vec3& x) { return body.v + cross(body.w, x - body.r); }

// A unit vector and its rate, of a vector of that length.
struct Direction {
  Vec3 n, rate;
  double length;
};
Direction direction_of(const Vec3& d, const Vec3& rate) {
  const double length = norm(d);
  if (!(length > 0)) return {{0, 0, 1}, {}, 0};
  const Vec3 n = (1 / length) * d;
  return {n, (1 / length) * (rate - dot(n, rate) * n), length};
}

// The lines' nearest points p_a + s·a and p_b + t·b, and their rates.
struct Nearest {
  double s, t, s_rate, t_rate;
};
Nearest nearest(const Vec3& from, const Vec3& from_rate, const Vec3& a, const Vec3& a_rate, const Vec3& b, const Vec3& b_rate) {
  // from = p_a − p_b: (from + s a − t b) is perpendicular to a and b.
  const double c = dot(a, b), c_rate = dot(a_rate, b) + dot(a, b_rate);
  const double fa = dot(from, a), fb = dot(from, b);
  const double fa_rate = dot(from_rate, a) + dot(from, a_rate), fb_rate = dot(from_rate, b) + dot(from, b_rate);
  const double square = 1 - c * c;
  if (!(square > 0)) return {0, 0, 0, 0};
  const double s = (c * fb - fa) / square, t = (fb - c * fa) / square;
  const double square_rate = -2 * c * c_rate;
  return {s, t, (c_rate * fb + c * fb_rate - fa_rate - s * square_rate) / square,
          (fb_rate - c_rate * fa - c * fa_rate - t * square_rate) / square};
}

}  // namespace

void perpendiculars(const Vec3& n, Vec3* tangent) noexcept {
  const Vec3 other = std::fabs(n.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  tangent[0] = normalized(cross(n, other));
  tangent[1] = cross(n, tangent[0]);
}

Vec3 relative_velocity(const Touch& touch, const Place& a, const Place& b) noexcept {
  return velocity_at(a, touch.point) - velocity_at(b, touch.point);
}

Touch touch(const Features& f, const Place& a, const Place& b) noexcept {
  Touch out;
  const Vec3 pa = place_of(a, f.point_a), pb = place_of(b, f.point_b);
  const Vec3 va = velocity_at(a, pa), vb = velocity_at(b, pb);
  Vec3 surface = pa, surface_rate = va;  // the point of a before it is rounded
  switch (f.pair) {
    case FeaturePair::point_plane:
      out.normal = b.R * f.line_b;
      out.normal_rate = cross(b.w, out.normal);
      out.gap = dot(out.normal, pa - pb);
      break;
    case FeaturePair::point_point: {
      const Direction d = direction_of(pa - pb, va - vb);
      out.normal = d.n, out.normal_rate = d.rate, out.gap = d.length;
      break;
    }
    case FeaturePair::point_line: {
      const Vec3 along = b.R * f.line_b, along_rate = cross(b.w, along), from = pa - pb, from_rate = va - vb;
      const double s = dot(along, from), s_rate = dot(along_rate, from) + dot(along, from_rate);
      const Direction d = direction_of(from - s * along, from_rate - s_rate * along - s * along_rate);
      out.normal = d.n, out.normal_rate = d.rate, out.gap = d.length;
      break;
    }
    case FeaturePair::line_line: {
      const Vec3 la = a.R * f.line_a, la_rate = cross(a.w, la), lb = b.R * f.line_b, lb_rate = cross(b.w, lb);
      const Direction d = direction_of(f.side * cross(la, lb), f.side * (cross(la_rate, lb) + cross(la, lb_rate)));
      out.normal = d.n, out.normal_rate = d.rate, out.gap = dot(d.n, pa - pb);
      const Nearest at = nearest(pa - pb, va - vb, la, la_rate, lb, lb_rate);
      surface = pa + at.s * la, surface_rate = va + at.s_rate * la + at.s * la_rate;
      break;
    }
    case FeaturePair::circle_plane: {
      const Vec3 axis = a.R * f.line_a, axis_rate = cross(a.w, axis);
      out.normal = b.R * f.line_b;
      out.normal_rate = cross(b.w, out.normal);
      // By vector products: perpendicular to the axis also where it is nearly normal to the plane.
      const Vec3 level = cross(axis, out.normal), level_rate = cross(axis_rate, out.normal) + cross(axis, out.normal_rate);
      Direction down = direction_of(cross(axis, level), cross(axis_rate, level) + cross(axis, level_rate));
      if (!(down.length > 0)) perpendiculars(axis, out.tangent), down.n = out.tangent[0];
      surface = pa + f.rim * down.n, surface_rate = va + f.rim * down.rate;
      out.gap = dot(out.normal, surface - pb);
      break;
    }
    case FeaturePair::point_circle: {
      const Vec3 axis = b.R * f.line_b, axis_rate = cross(b.w, axis), from = pa - pb, from_rate = va - vb;
      const double s = dot(axis, from), s_rate = dot(axis_rate, from) + dot(axis, from_rate);
      const Direction out_from = direction_of(from - s * axis, from_rate - s_rate * axis - s * axis_rate);
      const Direction d = direction_of(from - f.rim * out_from.n, from_rate - f.rim * out_from.rate);
      out.normal = d.n, out.normal_rate = d.rate, out.gap = d.length;
      break;
    }
    case FeaturePair::cable: {
      const Direction d = direction_of(pb - pa, vb - va);
      out.normal = d.n, out.normal_rate = d.rate, out.gap = f.length - d.length;
      break;
    }
    case FeaturePair::circle_line:
      (f.length > 0 ? circle_before_circle : circle_before_line)(f, a, b, out, surface_rate);
      surface = out.point;
      break;
    case FeaturePair::ellipsoid_plane:
    case FeaturePair::ellipsoid_line:
    case FeaturePair::ellipsoids:
      ellipsoid_before(f, a, b, out, surface_rate);
      surface = out.point;
      break;
  }
  out.gap -= f.radius_a + f.radius_b;
  out.point = surface - f.radius_a * out.normal;
  out.point_rate = surface_rate - f.radius_a * out.normal_rate;
  perpendiculars(out.normal, out.tangent);
  return out;
}

Along nearest_along(const Features& f, const Place& a, const Place& b) noexcept {
  const Vec3 pa = place_of(a, f.point_a), pb = place_of(b, f.point_b);
  if (f.pair == FeaturePair::point_line) return {0, dot(b.R * f.line_b, pa - pb)};
  if (f.pair != FeaturePair::line_line) return {};
  const Nearest at = nearest(pa - pb, {}, a.R * f.line_a, {}, b.R * f.line_b, {});
  return {at.s, at.t};
}

}  // namespace momentree::contact
