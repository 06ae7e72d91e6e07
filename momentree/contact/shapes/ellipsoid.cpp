#include <momentree/contact/shapes/ellipsoid.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include <momentree/contact/candidates_impl.hpp>

namespace momentree::contact {

namespace {

constexpr int most_steps = 60, most_retries = 12;
constexpr double longest_turn = 0.7;  // rad, of a step

// An ellipsoid, or another smooth solid, in the world, about its centre. Others than ellipsoids are not symmetric: of body a, its
// mirror image counts, which is farthest along n where the solid is farthest against it.
struct Extent {
  Axes axes;
  const SmoothSurface* surface;
  double side;  // −1: mirrored
  Extent(const Axes& own, const Mat3& R, unsigned char number = 0, double mirrored = 1)
      : axes{R * own[0], R * own[1], R * own[2]}, surface(number == 0 ? nullptr : smooth_surface(number)), side(mirrored) {}
  Vec3 M(const Vec3& n) const { return {dot(axes[0], n), dot(axes[1], n), dot(axes[2], n)}; }
  Vec3 transposed_M(const Vec3& u) const { return u.x * axes[0] + u.y * axes[1] + u.z * axes[2]; }
  double h(const Vec3& n) const { return surface != nullptr ? dot(n, x(n)) : norm(M(n)); }
  Vec3 x(const Vec3& n) const {
    if (surface != nullptr) return side * surface->farthest(axes, side * n);
    const Vec3 u = M(n);
    const double size = norm(u);
    return size > 0 ? (1 / size) * transposed_M(u) : Vec3{};
  }
  Vec3 H(const Vec3& n, const Vec3& turn) const {
    if (surface != nullptr) return surface->farthest_rate(axes, side * n, turn);
    const Vec3 u = M(n), moved = M(turn);
    const double size = norm(u);
    if (!(size > 0)) return {};
    return (1 / size) * transposed_M(moved - (dot(u, moved) / (size * size)) * u);
  }
};

// How n can turn, and by how much it has to.
struct Turning {
  std::array<Vec3, 2> along{};
  bool one = false;  // along[0] alone
  Turning(const Vec3& n, const Vec3* line) : one(line != nullptr) {
    if (line != nullptr)
      along[0] = cross(*line, n);
    else
      perpendiculars(n, along.data());
  }
  // (H_a + H_b + gap) turn = right, of components along these directions.
  Vec3 solve(const Extent& a, const Extent& b, const Vec3& n, double gap, const Vec3& right, bool ascending) const {
    const auto H = [&](std::size_t k) { return a.H(n, along[k]) + b.H(n, along[k]); };
    const Vec3 first = H(0);
    double xx = dot(along[0], first), xy = 0, yy = 0;
    if (!one) {
      const Vec3 second = H(1);
      xy = 0.5 * (dot(along[1], first) + dot(along[0], second)), yy = dot(along[1], second);
    }
    const auto singular = [&] { return !(xx + gap > 0) || (!one && !((xx + gap) * (yy + gap) > xy * xy * (1 + 1e-12))); };
    if (singular()) {
      if (!ascending) return {};
      gap = std::fabs(gap) + 1e-9 * (xx + yy);
    }
    const double r0 = dot(along[0], right), r1 = one ? 0 : dot(along[1], right);
    if (one) return (r0 / (xx + gap)) * along[0];
    const double determinant = (xx + gap) * (yy + gap) - xy * xy;
    return ((r0 * (yy + gap) - r1 * xy) / determinant) * along[0] + ((r1 * (xx + gap) - r0 * xy) / determinant) * along[1];
  }
};

// The n along which two ellipsoids are farthest apart: Newton's method on the unit sphere, with steps that are halved until the
// separation grows. `from`: from the centre of b to that of a.
Vec3 farthest_apart(const Extent& a, const Extent& b, const Vec3& from, const Vec3* line) {
  const auto separation = [&](const Vec3& n) { return dot(n, from) - a.h(n) - b.h(n); };
  Vec3 n = line != nullptr ? from - dot(from, *line) * *line : from;
  if (!(norm(n) > 0)) {
    Vec3 any[2];
    perpendiculars(line != nullptr ? *line : Vec3{0, 0, 1}, any);
    n = any[0];
  }
  n = normalized(n);
  const double size = norm(from) + a.h(n) + b.h(n);
  double now = separation(n);
  for (int k = 0; k < most_steps; ++k) {
    const Turning turning(n, line);
    Vec3 turn = turning.solve(a, b, n, now, from - a.x(n) - b.x(n), true);
    const double angle = norm(turn);
    if (!(angle > 0)) break;
    if (angle > longest_turn) turn = (longest_turn / angle) * turn;
    bool grows = false;
    for (int j = 0; j < most_retries && !grows; ++j, turn = 0.5 * turn) {
      Vec3 next = n + turn;
      if (line != nullptr) next -= dot(next, *line) * *line;
      next = normalized(next);
      const double there = separation(next);
      grows = there >= now - 1e-15 * size;
      if (grows) n = next, now = there;
    }
    if (!grows || angle < 1e-15) break;
  }
  return n;
}

// The point of a circle around zero that is nearest to an ellipsoid, by its direction from the centre: Newton's method for its
// angle, from where the disc is nearest. That has a kink along the axis, where the lowest point of the ellipsoid tells.
// Writes n of that point.
Vec3 nearest_of_rim(const Extent& a, const Vec3& from, const Vec3& axis, double rim, Vec3& n) {
  constexpr double kink = 1e-3;  // rad
  Vec3 any[2];
  perpendiculars(axis, any);
  const Extent point({}, {}), disc({rim * any[0], rim * any[1], Vec3{}}, identity3<double>());
  const auto across = [&](const Vec3& v) { return v - dot(v, axis) * axis; };
  Vec3 radial = across(farthest_apart(a, disc, from, nullptr));
  if (norm(radial) < kink) radial = across(from - a.x(dot(from, axis) < 0 ? -axis : axis));
  radial = norm(radial) > 0 ? normalized(radial) : any[0];
  for (int k = 0; k < most_steps; ++k) {
    const Vec3 tangent = cross(axis, radial), apart = from - rim * radial;
    n = farthest_apart(a, point, apart, nullptr);
    const double gap = dot(n, apart) - a.h(n);
    const Vec3 turns = Turning(n, nullptr).solve(a, point, n, gap, rim * tangent, true);
    const double slope = dot(tangent, turns) + dot(n, radial);
    if (!(slope > 0)) break;
    const double turn = std::clamp(dot(n, tangent) / slope, -longest_turn, longest_turn);
    radial = normalized(turned(radial, tangent, turn));
    if (std::fabs(turn) < 1e-15) break;
  }
  return radial;
}

}  // namespace

void ellipsoid_before(const Features& f, const Place& a, const Place& b, Touch& out, Vec3& rate) noexcept {
  const Vec3 centre_a = a.r + a.R * f.point_a, centre_b = b.r + b.R * f.point_b, line = b.R * f.line_b,
             from = centre_a - centre_b;
  const Extent of_a(f.axes_a, a.R, f.surface_a, -1), of_b(f.axes_b, b.R, f.surface_b);
  const bool plane = f.pair == FeaturePair::ellipsoid_plane, rim = f.rim > 0;
  const Vec3* const across = f.pair == FeaturePair::ellipsoid_line ? &line : nullptr;
  Vec3 n = line, on_b = centre_b;
  if (rim)
    on_b += f.rim * nearest_of_rim(of_a, from, line, f.rim, n);
  else if (!plane)
    n = farthest_apart(of_a, of_b, from, across);
  const Vec3 on_a = centre_a - of_a.x(n);
  on_b += of_b.x(n);
  out.normal = n, out.gap = dot(n, on_a - on_b), out.point = on_a;
  const Vec3 turned_a = cross(a.w, n), turned_b = cross(b.w, n), va = a.v + cross(a.w, on_a - a.r);
  if (plane) {
    out.normal_rate = turned_b;
  } else {
    if (across != nullptr) on_b += dot(line, on_a - on_b) * line, out.normal_rate = -dot(n, cross(b.w, line)) * line;
    const Vec3 vb = b.v + cross(b.w, on_b - b.r), fixed = out.normal_rate;
    const Turning turning(n, across);
    const auto turn = [&](const Vec3& right) { return turning.solve(of_a, of_b, n, out.gap, right, false); };
    out.normal_rate += turn(va - vb + of_a.H(n, turned_a - fixed) + of_b.H(n, turned_b - fixed));
    if (rim) {  // the point moves along the rim, perpendicular to n
      const Vec3 radial = on_b - centre_b, tangent = cross(line, radial), turns = turn(tangent);
      const double slope = dot(tangent, turns) + dot(n, radial);
      const double along = dot(tangent, out.normal_rate) + dot(n, cross(b.w, tangent));
      if (slope > 0) out.normal_rate -= (along / slope) * turns;
    }
  }
  rate = va - of_a.H(n, out.normal_rate - turned_a);
}

namespace {

// Features of the other solid, of which the nearest is kept.
struct EllipsoidSearch {
  const Solid &ellipsoid, &other;
  const Place &place, &of_other;
  bool swapped;
  double depth;  // up to which the nearest feature is that of the ellipsoid's parallel surface so deep inside
  Candidate nearest{{}, false, 0, HUGE_VAL};
  Candidate highest{{}, false, 0, -HUGE_VAL};  // of surfaces: that which it is the least below

  Features features(FeaturePair pair, const Vec3& point, const Vec3& line = {}) const {
    Features f;
    f.pair = pair, f.point_a = ellipsoid.centre, f.axes_a = ellipsoid.axes, f.point_b = point, f.line_b = line;
    f.radius_b = other.radius, f.surface_a = ellipsoid.surface;
    return f;
  }
  // `has`: the feature has that point of its plane or line, in the frame of the other solid; of points no more is asked.
  template <class Has>
  bool look(const Features& f, std::size_t number, bool surface, Has has) {
    const Touch t = touch(f, place, of_other);
    const auto candidate = [&] { return Candidate{f, swapped, id_of(f.pair, swapped, 0, number), t.gap}; };
    if (surface && t.gap > highest.gap) highest = candidate();
    if (!(t.gap + depth > 0) || !(t.gap < nearest.gap)) return false;
    if (!has(into(of_other, t.point - t.gap * t.normal))) return false;
    nearest = candidate();
    return true;
  }
  // All of the other solid is behind the plane through its nearest point: otherwise it is deep in the ellipsoid.
  bool separates() const {
    if (!(nearest.gap < HUGE_VAL)) return false;
    const Touch t = touch(nearest.features, place, of_other);
    const Vec3 n = transpose_times(of_other.R, t.normal);
    const double limit = dot(n, into(of_other, t.point)) - t.gap + 1e-9 * other.reach;
    if (!(other.rim > 0))
      return std::ranges::all_of(other.vertices, [&](const Vec3& v) { return dot(n, v) + other.radius <= limit; });
    const double across = other.rim * norm(cross(n, normalized(other.ends[1] - other.ends[0])));
    return std::ranges::all_of(other.ends, [&](const Vec3& end) { return dot(n, end) + across <= limit; });
  }
  double at_least(const Vec3& own) const {  // the distance of a point
    return norm(into(of_other, out_of(place, ellipsoid.centre)) - own) - ellipsoid.reach - other.radius;
  }

  void edged() {
    for (std::size_t k = 0; k < other.faces.size(); ++k) {
      const Solid::Face& face = other.faces[k];
      const Features f = features(FeaturePair::ellipsoid_plane, other.vertices[at(face.corners[0])], face.normal);
      if (look(f, k, true, [&](const Vec3& p) { return above_face(other, face, p); })) return;
    }
    for (std::size_t k = 0; k < other.vertices.size(); ++k)
      if (at_least(other.vertices[k]) < nearest.gap)
        look(features(FeaturePair::ellipsoids, other.vertices[k]), k, false, [](const Vec3&) { return true; });
    for (std::size_t k = 0; k < other.edges.size(); ++k) {
      const Line line = line_of(other, other.edges[k]);
      if (at_least(line.from + 0.5 * line.length * line.along) - 0.5 * line.length >= nearest.gap) continue;
      const auto on_line = [&](const Vec3& p) {
        const double s = dot(line.along, p - line.from);
        return s >= 0 && s <= line.length;
      };
      look(features(FeaturePair::ellipsoid_line, line.from, line.along), k, other.faces.empty(), on_line);
    }
  }

  void cylinder() {
    const Vec3 along = other.ends[1] - other.ends[0], axis = normalized(along);
    const double length = norm(along);
    for (std::size_t end = 0; end < 2; ++end) {
      const Vec3 centre = other.ends[end], outward = end == 0 ? -axis : axis;
      const auto in_disc = [&](const Vec3& p) { return norm(cross(axis, p - centre)) <= other.rim; };
      if (look(features(FeaturePair::ellipsoid_plane, centre, outward), end, true, in_disc)) return;
    }
    Features side = features(FeaturePair::ellipsoid_line, other.ends[0], axis);
    side.radius_b = other.rim;
    const auto beside = [&](const Vec3& p) {
      const double s = dot(axis, p - other.ends[0]);
      return s >= 0 && s <= length;
    };
    if (look(side, 2, true, beside)) return;
    for (std::size_t end = 0; end < 2; ++end) {
      Features rim = features(FeaturePair::ellipsoids, other.ends[end], axis);
      rim.rim = other.rim;
      look(rim, end, false, [](const Vec3&) { return true; });
    }
  }
};

double smallest_curvature_radius(const Solid& ellipsoid) {
  const double least = 0.5 * ellipsoid.thickness;
  return least * least / ellipsoid.reach;
}

}  // namespace

Candidate nearest_of_ellipsoid(const Solid& ellipsoid, const Place& of_ellipsoid, const Solid& other, const Place& of_other,
                               bool swapped) {
  EllipsoidSearch search{ellipsoid, other, of_ellipsoid, of_other, swapped, smallest_curvature_radius(ellipsoid) + other.radius};
  if (other.is_smooth() || other.vertices.size() == 1) {
    Features f = search.features(FeaturePair::ellipsoids, other.centre);
    if (other.is_smooth()) f.axes_b = other.axes, f.surface_b = other.surface, f.radius_b = 0;
    return {f, swapped, id_of(f.pair, swapped, 0, 0), touch(f, of_ellipsoid, of_other).gap};
  }
  if (other.rim > 0)
    search.cylinder();
  else
    search.edged();
  return search.separates() ? search.nearest : search.highest;
}

NearestPoints ellipsoid_distance(const Solid& ellipsoid, const Place& of_ellipsoid, const Solid& other, const Place& of_other) {
  const Candidate nearest = nearest_of_ellipsoid(ellipsoid, of_ellipsoid, other, of_other);
  const Touch t = touch(nearest.features, of_ellipsoid, of_other);
  return {t.gap, t.point, t.point - t.gap * t.normal, t.normal};
}

}  // namespace momentree::contact
