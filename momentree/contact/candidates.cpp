#include <momentree/contact/candidates.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <momentree/contact/candidates_impl.hpp>
#include <momentree/contact/shapes/cylinder.hpp>
#include <momentree/contact/shapes/cylinder_pair.hpp>
#include <momentree/contact/shapes/ellipsoid.hpp>

namespace momentree::contact {

namespace {

struct Search {
  const Solid &one, &other;
  const Place &place_one, &place_other;
  double within;
  std::vector<Candidate>& out;
  std::vector<Vec3>& scratch;
  double deepest = 0;  ///< overlaps of edges up to this count

  double rounding() const { return one.radius + other.radius; }

  void add(bool swapped, Features f, std::size_t a, std::size_t b) const {
    const Solid &of_a = swapped ? other : one, &of_b = swapped ? one : other;
    f.radius_a = of_a.radius, f.radius_b = of_b.radius;
    const double gap = touch(f, swapped ? place_other : place_one, swapped ? place_one : place_other).gap;
    if (gap < within) out.push_back({f, swapped, id_of(f.pair, swapped, a, b), gap});
  }

  // Vertices of a before b.
  void vertices(bool swapped) const {
    const Solid &a = swapped ? other : one, &b = swapped ? one : other;
    const Place &place_a = swapped ? place_other : place_one, &place_b = swapped ? place_one : place_other;
    for (std::size_t i = 0; i < a.vertices.size(); ++i) {
      const Vec3& own = a.vertices[i];
      const Vec3 p = into(place_b, out_of(place_a, own));
      if (norm(p - b.centre) > b.reach + a.radius + within) continue;
      std::vector<Vec3>& edges_there = scratch;
      edges_there.clear();
      for (const Vec3& edge : a.along[i]) edges_there.push_back(transpose_times(place_b.R, place_a.R * edge));
      const Height height = over_faces(b, p, edges_there);
      if (height.face >= 0) {
        if (height.above - rounding() >= within) continue;
        const Solid::Face& face = b.faces[at(height.face)];
        if (height.above <= 0 || above_face(b, face, p)) {
          // A vertex far below a face that is not its nearest one is no contact: over_faces takes the nearest.
          add(swapped, {FeaturePair::point_plane, own, {}, b.vertices[at(face.corners[0])], face.normal}, i, at(height.face));
          continue;
        }
        if (!(rounding() > 0)) continue;  // edges that cross, or vertices of the other solid, are nearer
      }
      before_edges(swapped, a, b, i, p);
    }
  }

  // A rounded vertex before the nearest edge or vertex.
  void before_edges(bool swapped, const Solid& a, const Solid& b, std::size_t i, const Vec3& p) const {
    double nearest = HUGE_VAL;
    std::size_t edge = 0;
    int vertex = -1;
    if (b.edges.empty()) nearest = norm(p - b.vertices[0]), vertex = 0;
    for (std::size_t e = 0; e < b.edges.size(); ++e) {
      const Line line = line_of(b, b.edges[e]);
      const double s = dot(line.along, p - line.from), t = std::clamp(s, 0.0, line.length);
      const double distance = norm(p - (line.from + t * line.along));
      if (!(distance < nearest)) continue;
      nearest = distance, edge = e;
      vertex = s <= 0 ? b.edges[e].ends[0] : s >= line.length ? b.edges[e].ends[1] : -1;
    }
    if (nearest - rounding() >= within) return;
    if (vertex >= 0) {
      // Both solids see a pair of vertices: once is enough.
      if (!swapped || !faces_vertex(one, place_one, at(vertex), a.vertices[i]))
        add(swapped, {FeaturePair::point_point, a.vertices[i], {}, b.vertices[at(vertex)], {}}, i, at(vertex));
    } else {
      const Line line = line_of(b, b.edges[edge]);
      add(swapped, {FeaturePair::point_line, a.vertices[i], {}, line.from, line.along}, i, edge);
    }
  }
  // True if the vertices pass found the pair of that vertex of `one` with a vertex of `other` already.
  bool faces_vertex(const Solid&, const Place&, std::size_t vertex, const Vec3& own) const {
    return std::any_of(out.begin(), out.end(), [&](const Candidate& c) {
      return c.features.pair == FeaturePair::point_point && !c.swapped && c.features.point_a == one.vertices[vertex] &&
             c.features.point_b == own;
    });
  }

  // Edges of the other solid in the world, some at a time: every edge of the first one meets them.
  struct WorldLine {
    Line own;
    Vec3 along, middle;
  };
  static constexpr std::size_t some = 64;

  void edges() const {
    std::array<WorldLine, some> lines;
    for (std::size_t first = 0; first < other.edges.size(); first += some) {
      const std::size_t count = std::min(some, other.edges.size() - first);
      for (std::size_t k = 0; k < count; ++k) {
        const Line line = line_of(other, other.edges[first + k]);
        lines[k] = {line, place_other.R * line.along, out_of(place_other, line.from + 0.5 * line.length * line.along)};
      }
      edges_before(lines, first, count);
    }
  }

  void edges_before(const std::array<WorldLine, some>& lines, std::size_t first, std::size_t count) const {
    for (std::size_t i = 0; i < one.edges.size(); ++i) {
      const Line a = line_of(one, one.edges[i]);
      const Vec3 middle = out_of(place_one, a.from + 0.5 * a.length * a.along), la = place_one.R * a.along;
      const double near = 0.5 * a.length + rounding() + std::max(within, deepest);
      const Vec3 from_centre = middle - out_of(place_other, other.centre);
      if (dot(from_centre, from_centre) > (near + other.reach) * (near + other.reach)) continue;
      for (std::size_t n_other = 0; n_other < count; ++n_other) {
        const std::size_t k = first + n_other;
        const Line& b = lines[n_other].own;
        const Vec3 between = middle - lines[n_other].middle;
        if (const double far = near + 0.5 * b.length; dot(between, between) > far * far) continue;
        const Vec3 &lb = lines[n_other].along, normal = cross(la, lb);
        const double sine = norm(normal);
        if (sine < parallel) continue;
        Features f{FeaturePair::line_line, a.from, a.along, b.from, b.along};
        const Along where = nearest_along(f, place_one, place_other);
        // Ends of edges are vertices, which face the other solid themselves.
        const double end_a = edge_slack * one.reach, end_b = edge_slack * other.reach;
        if (!(where.a > end_a && where.a < a.length - end_a && where.b > end_b && where.b < b.length - end_b)) continue;
        const Vec3 apart = out_of(place_one, a.from) + where.a * la - out_of(place_other, b.from) - where.b * lb;
        if (norm(apart) - rounding() >= std::max(within, deepest)) continue;
        for (const double side : {1.0, -1.0}) {
          const Vec3 n = (side / sine) * normal;
          if (rounding() > 0 && one.faces.empty() && other.faces.empty() && dot(n, apart) < 0) continue;
          if (!leaves(one, place_one, one.edges[i], a, -n) || !leaves(other, place_other, other.edges[k], b, n)) continue;
          f.side = side;
          add(false, f, i, k);
          break;
        }
      }
    }
  }
};

// A cylinder on a plane touches it with the lowest points of its ends, one that stands on it with points around its rim.
void cylinder_on_plane(const Solid& solid, const Place& place, const Vec3& point, const Vec3& normal, const Place& of_plane,
                       double within, std::vector<Candidate>& out) {
  const Vec3 axis = normalized(solid.ends[1] - solid.ends[0]);
  const bool stands = solid.rim * norm(cross(place.R * axis, of_plane.R * normal)) < standing;
  Vec3 across[2];
  perpendiculars(axis, across);
  for (std::size_t end = 0; end < 2; ++end) {
    Features f{FeaturePair::circle_plane, solid.ends[end], axis, point, normal};
    f.rim = solid.rim;
    if (!stands) {
      const double gap = touch(f, place, of_plane).gap;
      if (gap < within) out.push_back({f, false, id_of(f.pair, false, end, 0), gap});
      continue;
    }
    // All of them as low as the lowest: together they are one contact.
    const double gap = touch(f, place, of_plane).gap;
    if (!(gap < within)) continue;
    f.pair = FeaturePair::point_plane, f.line_a = {}, f.rim = 0;
    for (std::size_t k = 0; k < points_of_rim; ++k) {
      const double angle = static_cast<double>(k) * 2 * std::numbers::pi / points_of_rim;
      f.point_a = solid.ends[end] + solid.rim * turned(across[0], across[1], angle);
      out.push_back({f, false, id_of(f.pair, false, points_of_rim * end + k, 0), gap});
    }
  }
}

// A ball, the first solid unless they are swapped, before the side, an end or a rim of a cylinder.
void ball_before_cylinder(const Solid& ball, const Place& of_ball, const Solid& cylinder, const Place& of_cylinder, bool swapped,
                          double within, std::vector<Candidate>& out) {
  const Vec3 axis = normalized(cylinder.ends[1] - cylinder.ends[0]), p = into(of_cylinder, out_of(of_ball, ball.vertices[0]));
  const double from_low = dot(axis, p - cylinder.ends[0]), from_high = dot(axis, p - cylinder.ends[1]);
  const double beyond = std::max(-from_low, from_high), aside = norm(p - cylinder.ends[0] - from_low * axis) - cylinder.rim;
  const std::size_t end = -from_low > from_high ? 0 : 1;
  Features f;
  f.point_a = ball.vertices[0], f.radius_a = ball.radius, f.line_b = axis;
  if (beyond > 0 && aside > 0) {
    f.pair = FeaturePair::point_circle, f.point_b = cylinder.ends[end], f.rim = cylinder.rim;
  } else if (beyond > aside) {
    f.pair = FeaturePair::point_plane, f.point_b = cylinder.ends[end], f.line_b = end == 0 ? -axis : axis;
  } else {
    f.pair = FeaturePair::point_line, f.point_b = cylinder.ends[0], f.radius_b = cylinder.rim;
  }
  const double gap = touch(f, of_ball, of_cylinder).gap;
  if (gap < within) out.push_back({f, swapped, id_of(f.pair, swapped, 0, end), gap});
}

// True if all of a solid is farther than `within` above a face of another one.
bool is_above_a_face(const Solid& solid, const Place& place, const Solid& other, const Place& of_other, double within) {
  const Vec3 from = transpose_times(place.R, of_other.r - place.r);
  for (const Solid::Face& face : solid.faces) {
    const Vec3 normal = transpose_times(of_other.R, place.R * face.normal);
    const double least = within + solid.radius + other.radius + face.offset - dot(face.normal, from);
    const auto near = [&](const Vec3& v) { return dot(normal, v) <= least; };
    if (std::none_of(other.vertices.begin(), other.vertices.end(), near)) return true;
  }
  return false;
}

bool is_ball(const Solid& solid) { return solid.vertices.size() == 1; }

}  // namespace

void face_plane(const Solid& solid, const Place& place, const Vec3& point, const Vec3& normal, const Place& of_plane,
                double within, std::vector<Candidate>& out) {
  if (solid.rim > 0) return cylinder_on_plane(solid, place, point, normal, of_plane, within, out);
  if (solid.is_smooth()) {
    Features f{FeaturePair::ellipsoid_plane, solid.centre, {}, point, normal};
    f.axes_a = solid.axes, f.surface_a = solid.surface;
    const double gap = touch(f, place, of_plane).gap;
    if (gap < within) out.push_back({f, false, id_of(f.pair, false, 0, 0), gap});
    return;
  }
  for (std::size_t i = 0; i < solid.vertices.size(); ++i) {
    const Features f{FeaturePair::point_plane, solid.vertices[i], {}, point, normal, solid.radius, 0};
    const double gap = touch(f, place, of_plane).gap;
    if (gap < within) out.push_back({f, false, id_of(f.pair, false, i, 0), gap});
  }
}

void face_each_other(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other, double within,
                     std::vector<Candidate>& out) {
  const Vec3 apart = out_of(place_one, one.centre) - out_of(place_other, other.centre);
  if (norm(apart) > one.reach + other.reach + within) return;
  if (one.is_smooth() || other.is_smooth()) {
    const bool swapped = !one.is_smooth();
    const Candidate nearest = swapped ? nearest_of_ellipsoid(other, place_other, one, place_one, true)
                                      : nearest_of_ellipsoid(one, place_one, other, place_other);
    if (nearest.gap < within) out.push_back(nearest);
    return;
  }
  if (is_ball(one) && other.rim > 0) return ball_before_cylinder(one, place_one, other, place_other, false, within, out);
  if (is_ball(other) && one.rim > 0) return ball_before_cylinder(other, place_other, one, place_one, true, within, out);
  if (one.rim > 0 && other.rim > 0) return cylinders_face(one, place_one, other, place_other, within, out);
  if (one.rim > 0 && other.rim == 0) return cylinder_faces(one, place_one, other, place_other, false, within, out);
  if (other.rim > 0 && one.rim == 0) return cylinder_faces(other, place_other, one, place_one, true, within, out);
  if (is_above_a_face(one, place_one, other, place_other, within) || is_above_a_face(other, place_other, one, place_one, within))
    return;
  std::vector<Vec3> scratch;
  const Search search{one, other, place_one, place_other, within, out, scratch};
  search.vertices(false);
  search.vertices(true);
  search.edges();
}

void cross_edges(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other, double within,
                 double deepest, std::vector<Candidate>& out) {
  std::vector<Vec3> none;
  Search{one, other, place_one, place_other, within, out, none, deepest}.edges();
}

}  // namespace momentree::contact
