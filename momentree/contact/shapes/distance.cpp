#include <momentree/contact/shapes/distance.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <momentree/contact/shapes/cylinder.hpp>
#include <momentree/contact/shapes/cylinder_overlap.hpp>
#include <momentree/contact/shapes/cylinder_pair.hpp>
#include <momentree/contact/shapes/ellipsoid.hpp>

namespace momentree::contact {

namespace {

constexpr int most_iterations = 200;

// A vertex of the difference of two solids, with the vertices that it comes from.
struct Vertex {
  Vec3 difference, on_one, on_other;
};

// The point of the hull of up to four vertices that is nearest to the origin, by its weights.
struct Simplex {
  std::array<Vertex, 4> vertices;
  std::array<double, 4> weights{};
  std::size_t count = 0;

  Vec3 sum(Vec3 Vertex::*of) const {
    Vec3 total{};
    for (std::size_t i = 0; i < count; ++i) total += weights[i] * (vertices[i].*of);
    return total;
  }
};

// The points of a subset, and its point that is nearest to zero; `inside`: with weights that are not negative.
struct ClosestOf {
  std::array<std::size_t, 4> of{};
  std::array<double, 4> weights{};
  std::size_t size = 0;
  Vec3 at{};
  bool inside = false;
};

constexpr double flat_simplex = 1e-12;  // relative to its edges, a triangle or a tetrahedron without volume

void closest_on_line(const Simplex& s, ClosestOf& n) {
  const Vec3 &a = s.vertices[n.of[0]].difference, along = s.vertices[n.of[1]].difference - a;
  const double square = dot(along, along);
  if (!(square > 0)) return;
  const double t = -dot(a, along) / square;
  n.weights = {1 - t, t, 0, 0};
  n.at = a + t * along;
  n.inside = t >= 0 && t <= 1;
}

void closest_on_triangle(const Simplex& s, ClosestOf& n) {
  const Vec3 &a = s.vertices[n.of[0]].difference, &b = s.vertices[n.of[1]].difference, &c = s.vertices[n.of[2]].difference;
  const Vec3 ab = b - a, ac = c - a, normal = cross(ab, ac);
  const double square = dot(normal, normal);
  if (!(square > flat_simplex * flat_simplex * dot(ab, ab) * dot(ac, ac))) return;
  n.at = (dot(normal, a) / square) * normal;
  const Vec3 from = n.at - a;
  const double u = dot(cross(from, ac), normal) / square, v = dot(cross(ab, from), normal) / square;
  n.weights = {1 - u - v, u, v, 0};
  n.inside = u >= 0 && v >= 0 && u + v <= 1;
}

void closest_in_tetrahedron(const Simplex& s, ClosestOf& n) {
  const Vec3& d = s.vertices[3].difference;
  const Vec3 a = s.vertices[0].difference - d, b = s.vertices[1].difference - d, c = s.vertices[2].difference - d;
  const double volume = dot(a, cross(b, c));
  if (!(std::fabs(volume) > flat_simplex * norm(a) * norm(b) * norm(c))) return;
  const double u = dot(-d, cross(b, c)) / volume, v = dot(a, cross(-d, c)) / volume, w = dot(a, cross(b, -d)) / volume;
  n.weights = {u, v, w, 1 - u - v - w};
  n.at = {};
  n.inside = u >= 0 && v >= 0 && w >= 0 && u + v + w <= 1;
}

// Keeps the points of the simplex between which its point nearest to zero lies; returns that point.
Vec3 reduce_simplex(Simplex& s) {
  ClosestOf best;
  double least = HUGE_VAL;
  for (unsigned subset = 1; subset < 1u << s.count; ++subset) {
    ClosestOf n;
    for (std::size_t i = 0; i < s.count; ++i)
      if ((subset >> i & 1u) != 0) n.of[n.size++] = i;
    if (n.size == 1) n.weights[0] = 1, n.at = s.vertices[n.of[0]].difference, n.inside = true;
    if (n.size == 2) closest_on_line(s, n);
    if (n.size == 3) closest_on_triangle(s, n);
    if (n.size == 4) closest_in_tetrahedron(s, n);
    const double square = dot(n.at, n.at);
    if (n.inside && square < least) least = square, best = n;
  }
  Simplex kept;
  for (std::size_t i = 0; i < best.size; ++i) kept.vertices[i] = s.vertices[best.of[i]];
  kept.weights = best.weights, kept.count = best.size;
  s = kept;
  return best.at;
}

std::size_t farthest(const Solid& solid, const Vec3& along) {
  std::size_t found = 0;
  double most = -HUGE_VAL;
  for (std::size_t i = 0; i < solid.vertices.size(); ++i)
    if (const double x = dot(along, solid.vertices[i]); x > most) most = x, found = i;
  return found;
}

// In closed form: a ball touches a cylinder as what it is.
NearestPoints ball_to_cylinder(const Solid& ball, const Place& of_ball, const Solid& cylinder, const Place& of_cylinder) {
  const Vec3 centre = of_ball.r + of_ball.R * ball.vertices[0], p = transpose_times(of_cylinder.R, centre - of_cylinder.r);
  const Vec3 along = cylinder.ends[1] - cylinder.ends[0];
  const double length = norm(along);
  const Vec3 axis = (1 / length) * along, from = p - cylinder.ends[0];
  const double height = dot(axis, from), beyond = height < 0 ? -height : std::max(0.0, height - length);
  const Vec3 aside = from - height * axis;
  const double off = norm(aside);
  Vec3 nearest = cylinder.ends[0] + std::clamp(height, 0.0, length) * axis;
  nearest += off > cylinder.rim ? (cylinder.rim / off) * aside : aside;
  NearestPoints result;
  result.on_other = of_cylinder.r + of_cylinder.R * nearest;
  const double apart = std::hypot(beyond, std::max(0.0, off - cylinder.rim));
  if (apart > 0) result.normal = normalized(centre - result.on_other);
  result.distance = apart - ball.radius, result.on_one = centre - ball.radius * result.normal;
  return result;
}

// The least gap of all features, and of all corners: none of them is less than the distance.
NearestPoints cylinder_to_edged(const Solid& cylinder, const Place& of_cylinder, const Solid& other, const Place& of_other) {
  NearestPoints best;
  if (cylinder_overlaps(cylinder, of_cylinder, other, of_other)) {
    best.distance = -other.radius;
    best.on_one = best.on_other = of_cylinder.r + of_cylinder.R * cylinder.centre;
    return best;
  }
  best.distance = HUGE_VAL;
  const auto look = [&](const NearestPoints& next) {
    if (next.distance < best.distance) best = next;
  };
  for (const Vec3& v : other.vertices) {
    const NearestPoints corner = ball_to_cylinder(sphere(other.radius, Pose(v)), of_other, cylinder, of_cylinder);
    look({corner.distance, corner.on_other, corner.on_one, -corner.normal});
  }
  std::vector<Candidate> features;
  cylinder_faces(cylinder, of_cylinder, other, of_other, false, best.distance, features);
  for (const Candidate& c : features) {
    const Touch t = touch(c.features, c.swapped ? of_other : of_cylinder, c.swapped ? of_cylinder : of_other);
    const Vec3 on_b = t.point - t.gap * t.normal;
    if (c.swapped)
      look({t.gap, on_b, t.point, -t.normal});
    else
      look({t.gap, t.point, on_b, t.normal});
  }
  return best;
}

NearestPoints swapped(const NearestPoints& nearest) {
  return {nearest.distance, nearest.on_other, nearest.on_one, -nearest.normal};
}

bool is_edged(const Solid& other) { return other.rim == 0 && other.vertices.size() > 1; }

bool is_round(const Solid& ball, const Solid& cylinder) { return ball.vertices.size() == 1 && cylinder.rim > 0; }

}  // namespace

NearestPoints distance(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other) {
  if (one.is_smooth()) return ellipsoid_distance(one, place_one, other, place_other);
  if (other.is_smooth()) return swapped(ellipsoid_distance(other, place_other, one, place_one));
  if (is_round(one, other)) return ball_to_cylinder(one, place_one, other, place_other);
  if (is_round(other, one)) return swapped(ball_to_cylinder(other, place_other, one, place_one));
  if (one.rim > 0 && other.rim > 0) return cylinders_distance(one, place_one, other, place_other);
  if (one.rim > 0 && is_edged(other)) return cylinder_to_edged(one, place_one, other, place_other);
  if (other.rim > 0 && is_edged(one)) return swapped(cylinder_to_edged(other, place_other, one, place_one));
  return distance_of_polyhedra(one, place_one, other, place_other);
}

NearestPoints distance_of_polyhedra(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other) {
  // Relative to the centre of the first solid, for rounding.
  const Vec3 origin = place_one.r + place_one.R * one.centre;
  const auto vertex = [&](const Vec3& along) {
    const Vec3 a = place_one.r - origin + place_one.R * one.vertices[farthest(one, transpose_times(place_one.R, -along))];
    const Vec3 b =
        place_other.r - origin + place_other.R * other.vertices[farthest(other, transpose_times(place_other.R, along))];
    return Vertex{a - b, a, b};
  };
  Simplex simplex;
  const Vec3 apart = origin - (place_other.r + place_other.R * other.centre);
  simplex.vertices[0] = vertex(norm(apart) > 0 ? apart : Vec3{1, 0, 0}), simplex.weights[0] = 1, simplex.count = 1;
  const double size = one.reach + other.reach;
  Vec3 nearest = simplex.vertices[0].difference;
  for (int k = 0; k < most_iterations; ++k) {
    const double square = dot(nearest, nearest);
    if (square <= 1e-26 * size * size) break;
    const Vertex next = vertex(nearest);
    const bool known =
        std::any_of(simplex.vertices.begin(), simplex.vertices.begin() + static_cast<std::ptrdiff_t>(simplex.count),
                    [&](const Vertex& v) { return v.difference == next.difference; });
    if (known || square - dot(nearest, next.difference) <= 1e-15 * square) break;
    Simplex trial = simplex;
    trial.vertices[trial.count++] = next;
    const Vec3 closer = reduce_simplex(trial);
    if (!(dot(closer, closer) < square)) break;
    simplex = trial, nearest = closer;
    if (simplex.count == 4) break;  // the origin is inside
  }
  NearestPoints result;
  const double cores = norm(nearest);
  if (cores > 0) result.normal = (1 / cores) * nearest;
  result.distance = cores - one.radius - other.radius;
  result.on_one = origin + simplex.sum(&Vertex::on_one) - one.radius * result.normal;
  result.on_other = origin + simplex.sum(&Vertex::on_other) + other.radius * result.normal;
  return result;
}

NearestPoints distance_to_plane(const Solid& solid, const Place& place, const Vec3& point, const Vec3& normal) {
  NearestPoints result;
  result.normal = normal, result.distance = HUGE_VAL;
  const auto look = [&](const Vec3& at) {
    const double above = dot(normal, at - point);
    if (above < result.distance) result.distance = above, result.on_one = at;
  };
  if (solid.is_smooth()) {
    std::vector<Candidate> one;
    face_plane(solid, place, point, normal, {}, HUGE_VAL, one);
    const Touch t = touch(one.front().features, place, {});
    return {t.gap, t.point, t.point - t.gap * normal, normal};
  }
  if (solid.rim > 0) {
    const Vec3 axis = place.R * normalized(solid.ends[1] - solid.ends[0]), across = normal - dot(normal, axis) * axis;
    const double sine = norm(across);
    for (const Vec3& end : solid.ends) look(place.r + place.R * end - (sine > 0 ? (solid.rim / sine) * across : Vec3{}));
  } else {
    for (const Vec3& v : solid.vertices) look(place.r + place.R * v);
  }
  result.distance -= solid.radius, result.on_one -= solid.radius * normal;
  result.on_other = result.on_one - result.distance * normal;
  return result;
}

}  // namespace momentree::contact
