#include <momentree/contact/distance.hpp>

#include <algorithm>
#include <array>
#include <cmath>

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

// Weights of the point nearest to the origin in the affine hull of some vertices; false if they are dependent.
bool nearest_in_hull(const std::array<Vec3, 4>& v, std::size_t n, std::array<double, 4>& weights) {
  // Of the origin relative to v0: least squares in the edges from v0, by their Gram matrix.
  double G[3][4];
  const std::size_t m = n - 1;
  for (std::size_t i = 0; i < m; ++i) {
    for (std::size_t j = 0; j < m; ++j) G[i][j] = dot(v[i + 1] - v[0], v[j + 1] - v[0]);
    G[i][3] = -dot(v[i + 1] - v[0], v[0]);
  }
  for (std::size_t k = 0; k < m; ++k) {  // the matrix is positive semidefinite: no pivoting
    const double size = dot(v[k + 1] - v[0], v[k + 1] - v[0]);
    if (!(G[k][k] > 1e-14 * size)) return false;
    for (std::size_t i = k + 1; i < m; ++i) {
      const double factor = G[i][k] / G[k][k];
      for (std::size_t j = k; j < m; ++j) G[i][j] -= factor * G[k][j];
      G[i][3] -= factor * G[k][3];
    }
  }
  weights[0] = 1;
  for (std::size_t k = m; k-- > 0;) {
    double x = G[k][3];
    for (std::size_t j = k + 1; j < m; ++j) x -= G[k][j] * weights[j + 1];
    weights[k + 1] = x / G[k][k];
  }
  for (std::size_t k = 0; k < m; ++k) weights[0] -= weights[k + 1];
  return true;
}

// Keeps the vertices of the face of the simplex that is nearest to the origin.
void reduce(Simplex& simplex) {
  Simplex best;
  double least = HUGE_VAL;
  for (unsigned set = 1; set < 1u << simplex.count; ++set) {
    std::array<Vec3, 4> v;
    std::array<std::size_t, 4> of{};
    std::size_t n = 0;
    for (std::size_t i = 0; i < simplex.count; ++i)
      if ((set >> i & 1u) != 0) of[n] = i, v[n++] = simplex.vertices[i].difference;
    std::array<double, 4> weights{};
    if (!nearest_in_hull(v, n, weights)) continue;
    if (std::any_of(weights.begin(), weights.begin() + static_cast<std::ptrdiff_t>(n), [](double w) { return !(w >= 0); }))
      continue;
    Vec3 point{};
    for (std::size_t i = 0; i < n; ++i) point += weights[i] * v[i];
    if (!(dot(point, point) < least)) continue;
    least = dot(point, point);
    best.count = n, best.weights = weights;
    for (std::size_t i = 0; i < n; ++i) best.vertices[i] = simplex.vertices[of[i]];
  }
  simplex = best;
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

bool is_round(const Solid& ball, const Solid& cylinder) { return ball.vertices.size() == 1 && cylinder.rim > 0; }

}  // namespace

NearestPoints distance(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other) {
  if (is_round(one, other)) return ball_to_cylinder(one, place_one, other, place_other);
  if (is_round(other, one)) {
    NearestPoints turned = ball_to_cylinder(other, place_other, one, place_one);
    std::swap(turned.on_one, turned.on_other);
    turned.normal = -turned.normal;
    return turned;
  }
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
    reduce(trial);
    const Vec3 closer = trial.sum(&Vertex::difference);
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
