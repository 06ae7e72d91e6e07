#include <momentree/contact/shapes/cylinder.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <momentree/contact/candidates_impl.hpp>
#include <momentree/contact/shapes/circle.hpp>
#include <momentree/contact/shapes/cylinder_overlap.hpp>

namespace momentree::contact {

namespace {

constexpr double thin = 0.5;           // a rim is seen along an edge as an ellipse; thinner ones have two sides
constexpr double nearly_along = 1e-4;  // sine of the angle of an edge and the tangent of a rim that it leaves at the same point
constexpr double flush = 1e-6;         // angles of faces beside an edge on which an end stands

struct CylinderSearch {
  const Solid &cylinder, &other;
  const Place &of_cylinder, &of_other;
  bool second;
  double within;
  std::vector<Candidate>& out;
  Vec3 axis;  // in the cylinder's frame
  double length;
  std::array<Vec3, 2> across{};

  Vec3 outward(std::size_t end) const { return end == 0 ? -axis : axis; }
  Vec3 world_end(std::size_t end) const { return out_of(of_cylinder, cylinder.ends[end]); }

  void push(bool cylinder_first, const Features& f, std::size_t a, std::size_t b, double gap) const {
    const bool swapped = cylinder_first == second;
    if (gap < within) out.push_back({f, swapped, id_of(f.pair, swapped, a, b), gap});
  }
  void add(bool cylinder_first, const Features& f, std::size_t a, std::size_t b) const {
    push(cylinder_first, f, a, b, touch(f, cylinder_first ? of_cylinder : of_other, cylinder_first ? of_other : of_cylinder).gap);
  }

  // A plane leaves everything on its other side.
  bool apart() const {
    const Vec3 centre = 0.5 * (world_end(0) + world_end(1)), along = of_cylinder.R * axis;
    for (const Solid::Face& face : other.faces) {
      const Vec3 n = of_other.R * face.normal;
      const double above = dot(n, centre - of_other.r) - face.offset - other.radius;
      if (above - 0.5 * length * std::fabs(dot(n, along)) - cylinder.rim * norm(cross(n, along)) >= within) return true;
    }
    for (std::size_t end = 0; end < 2; ++end) {
      const Vec3 n = of_cylinder.R * outward(end), from = world_end(end) - of_other.r;
      const Vec3 own = transpose_times(of_other.R, n);
      const double least = dot(n, from) + other.radius + within;
      if (std::none_of(other.vertices.begin(), other.vertices.end(), [&](const Vec3& v) { return dot(own, v) < least; }))
        return true;
    }
    return false;
  }

  // Corners before an end or the side; rounded ones also before a rim.
  void corners() const {
    const double slack = edge_slack * cylinder.reach;
    for (std::size_t i = 0; i < other.vertices.size(); ++i) {
      const Vec3 p = into(of_cylinder, out_of(of_other, other.vertices[i])), from = p - cylinder.ends[0];
      const double height = dot(axis, from), beyond = std::max(-height, height - length);
      const Vec3 radial = from - height * axis;
      const double aside = norm(radial) - cylinder.rim;
      if (std::max(beyond, aside) - other.radius >= within) continue;
      const std::size_t end = 2 * height > length ? 1 : 0;
      Features f;
      f.point_a = other.vertices[i], f.radius_a = other.radius, f.line_b = axis, f.point_b = cylinder.ends[end];
      if (beyond > 0 && aside > 0 && (other.radius > 0 || aside > slack)) {
        if (!(other.radius > 0)) continue;  // an edge that crosses the rim is nearer
        f.pair = FeaturePair::point_circle, f.rim = cylinder.rim;
        add(false, f, i, end);
        continue;
      }
      // What continues inward from the corner is not before that surface, unless the corner is above it.
      bool before_end = true, before_side = true;
      for (const Vec3& edge : other.along[i]) {
        const Vec3 own = transpose_times(of_cylinder.R, of_other.R * edge);
        before_end = before_end && (beyond > slack || dot(own, outward(end)) > -0.1);
        before_side = before_side && (aside > slack || dot(own, radial) > -0.1 * norm(radial));
      }
      if (before_end && (beyond > aside || !before_side)) {
        f.pair = FeaturePair::point_plane, f.line_b = outward(end);
        add(false, f, i, end);
      } else if (before_side) {
        f.pair = FeaturePair::point_line, f.point_b = cylinder.ends[0], f.radius_b = cylinder.rim;
        add(false, f, i, 0);
      }
    }
  }

  bool above_plane(std::size_t plane, const Vec3& p) const {
    for (const Solid::Face& face : other.faces)
      if (at(face.plane) == plane && above_face(other, face, p)) return true;
    return false;
  }
  // A point of the cylinder is before the plane of a face: above one of its faces, or inside and the least below it.
  bool before_plane(std::size_t plane, const Vec3& p) const {
    const double slack = edge_slack * other.reach, above = dot(other.faces[plane].normal, p) - other.faces[plane].offset;
    if (above > 0) return above_plane(plane, p);
    return std::all_of(other.faces.begin(), other.faces.end(),
                       [&](const Solid::Face& face) { return dot(face.normal, p) - face.offset <= above + slack; });
  }

  void rims_before_faces() const {
    for (std::size_t k = 0; k < other.faces.size(); ++k) {
      const Solid::Face& face = other.faces[k];
      if (at(face.plane) != k) continue;
      const Vec3 n = of_other.R * face.normal;
      const double tilt = norm(cross(of_cylinder.R * axis, n));
      for (std::size_t end = 0; end < 2; ++end) {
        Features f{FeaturePair::circle_plane, cylinder.ends[end], axis, other.vertices[at(face.corners[0])], face.normal};
        f.rim = cylinder.rim;
        const Touch lowest = touch(f, of_cylinder, of_other);
        if (!(lowest.gap < within)) continue;
        if (cylinder.rim * tilt >= standing) {
          if (before_plane(k, into(of_other, lowest.point))) push(true, f, end, k, lowest.gap);
          continue;
        }
        if (!(dot(n, of_cylinder.R * outward(end)) < 0)) continue;
        // An end that stands: all points of its rim are as low as the lowest.
        f.pair = FeaturePair::point_plane, f.line_a = {}, f.rim = 0;
        for (std::size_t i = 0; i < points_of_rim; ++i) {
          const double angle = static_cast<double>(i) * 2 * std::numbers::pi / points_of_rim;
          f.point_a = cylinder.ends[end] + cylinder.rim * turned(across[0], across[1], angle);
          if (before_plane(k, into(of_other, out_of(of_cylinder, f.point_a))))
            push(true, f, points_of_rim * end + i, k, lowest.gap);
        }
      }
    }
  }

  void edges() const {
    const Vec3 along = of_cylinder.R * axis, middle = 0.5 * (world_end(0) + world_end(1));
    for (std::size_t k = 0; k < other.edges.size(); ++k) {
      const Line line = line_of(other, other.edges[k]);
      const Vec3 from = out_of(of_other, line.from), to = of_other.R * line.along;
      const double s = std::clamp(dot(to, middle - from), 0.0, line.length);
      if (norm(from + s * to - middle) > cylinder.reach + other.radius + within) continue;
      edge_before_side(k, line, along, from, to);
      for (std::size_t end = 0; end < 2; ++end) edge_before_rim(k, line, end, from, to);
    }
  }

  bool inside(const Line& line, double s) const {
    const double slack = edge_slack * other.reach;
    return s > slack && s < line.length - slack;
  }

  void edge_before_side(std::size_t k, const Line& line, const Vec3& along, const Vec3& from, const Vec3& to) const {
    const Vec3 normal = cross(along, to);
    const double sine = norm(normal);
    if (sine < parallel) return;
    Features f{FeaturePair::line_line, cylinder.ends[0], axis, line.from, line.along, cylinder.rim, other.radius};
    const Along where = nearest_along(f, of_cylinder, of_other);
    const double slack = edge_slack * cylinder.reach;
    if (!(where.a > -slack && where.a < length + slack && inside(line, where.b))) return;
    const Vec3 apart = world_end(0) + where.a * along - from - where.b * to;
    for (const double side : {1.0, -1.0}) {
      const Vec3 n = (side / sine) * normal;
      if (dot(n, apart) < 0) continue;
      if (!leaves(other, of_other, other.edges[k], line, n)) continue;
      f.side = side;
      // An edge in the plane of an end is not inside.
      const double gap = norm(apart) - cylinder.rim - other.radius;
      if (gap < -slack && !(where.a > slack && where.a < length - slack)) return;
      add(true, f, 0, k);
      return;
    }
  }

  void edge_before_rim(std::size_t k, const Line& line, std::size_t end, const Vec3& from, const Vec3& to) const {
    const Vec3 centre = world_end(end), out_world = of_cylinder.R * outward(end);
    const double s = std::clamp(dot(to, centre - from), 0.0, line.length), seen = std::fabs(dot(out_world, to));
    if (norm(from + s * to - centre) > cylinder.rim + other.radius + within) return;
    // Beside an end that is parallel to it an edge passes the rim at one point.
    const Vec3 aside = from + dot(to, centre - from) * to - centre;
    const double off = norm(aside - dot(aside, out_world) * out_world);
    if (cylinder.rim * seen < standing && off < cylinder.rim) return edge_across_end(k, line, end, from, to);
    Features f{FeaturePair::circle_line, cylinder.ends[end], outward(end), line.from, line.along, 0, other.radius};
    f.rim = cylinder.rim, f.side = seen < thin ? 1 : 0;
    if (!nearest_to_line(centre - from, out_world, f.rim, to, f.side > 0).found) return;
    const Touch t = touch(f, of_cylinder, of_other);
    if (!(t.gap < within) || dot(t.normal, out_world) > parallel) return;
    if (!inside(line, dot(to, t.point - from)) || !leaves(other, of_other, other.edges[k], line, t.normal)) return;
    if (t.gap + other.radius < 0 && !holds(t.point - (t.gap + other.radius) * t.normal)) return;
    push(true, f, end, k, t.gap);
  }

  // The cylinder contains a point.
  bool holds(const Vec3& world) const {
    const double slack = edge_slack * cylinder.reach;
    const Vec3 from = into(of_cylinder, world) - cylinder.ends[0];
    const double height = dot(axis, from);
    return height > -slack && height < length + slack && norm(from - height * axis) < cylinder.rim + slack;
  }

  // An edge in the plane of an end touches it between two points of the rim: there with the tangents of the rim.
  void edge_across_end(std::size_t k, const Line& line, std::size_t end, const Vec3& from, const Vec3& to) const {
    const Vec3 centre = world_end(end), out_world = of_cylinder.R * outward(end);
    const double middle = dot(to, centre - from);
    const Vec3 aside = from + middle * to - centre;
    const double off = norm(aside - dot(aside, out_world) * out_world),
                 half = std::sqrt(std::max(0.0, cylinder.rim * cylinder.rim - off * off));
    if (!(half > nearly_along * cylinder.rim) || dot(aside, out_world) < -0.5 * length ||
        !leaves(other, of_other, other.edges[k], line, -out_world, flush))
      return;
    std::array<Features, 2> found{};
    std::array<std::size_t, 2> sector{};
    std::size_t count = 0;
    double lowest = HUGE_VAL;
    for (const double s : {middle - half, middle + half}) {
      if (!inside(line, s)) continue;
      const Vec3 p = into(of_cylinder, from + s * to) - cylinder.ends[end];
      const Vec3 radial = normalized(p - dot(axis, p) * axis), tangent = cross(axis, radial);
      Features f{
          FeaturePair::line_line, cylinder.ends[end] + cylinder.rim * radial, tangent, line.from, line.along, 0, other.radius};
      f.side = dot(cross(of_cylinder.R * tangent, to), out_world) < 0 ? 1 : -1;
      lowest = std::min(lowest, touch(f, of_cylinder, of_other).gap);
      const double turns = std::atan2(dot(radial, across[1]), dot(radial, across[0])) / (2 * std::numbers::pi);
      sector[count] = static_cast<std::size_t>((turns + 1) * points_of_rim);
      found[count++] = f;
    }
    for (std::size_t i = 0; i < count; ++i) push(true, found[i], 1 + 2 * sector[i] + end, k, lowest);
  }
};

}  // namespace

void cylinder_faces(const Solid& cylinder, const Place& of_cylinder, const Solid& other, const Place& of_other, bool second,
                    double within, std::vector<Candidate>& out) {
  const Vec3 along = cylinder.ends[1] - cylinder.ends[0];
  CylinderSearch search{cylinder, other, of_cylinder, of_other, second, within, out, normalized(along), norm(along)};
  if (search.apart()) return;
  perpendiculars(search.axis, search.across.data());
  const std::size_t first = out.size();
  search.corners();
  search.rims_before_faces();
  search.edges();
  // Deep overlaps have none of these features where solids are thin there.
  const auto negative = [](const Candidate& c) { return c.gap < 0; };
  if (std::any_of(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(), negative)) return;
  if (!cylinder_overlaps(cylinder, of_cylinder, other, of_other)) return;
  cylinder_overlap_points(cylinder, of_cylinder, other, of_other, second, 0, out);
}

Tilt tilt_of(const Features& f, const Place& a, const Place& b) {
  const Vec3 axis = a.R * f.line_a, other = b.R * f.line_b;
  const Vec3 axis_rate = cross(a.w, axis), other_rate = cross(b.w, other);
  const double along = dot(axis, other), rate = dot(axis_rate, other) + dot(axis, other_rate);
  if (f.pair == FeaturePair::circle_plane) {
    const double sine = norm(cross(axis, other));
    return {sine, sine > 0 ? -along * rate / sine : 0};
  }
  if (f.pair == FeaturePair::circle_line && f.side > 0) return {std::fabs(along), along < 0 ? -rate : rate};
  return {};
}

}  // namespace momentree::contact
