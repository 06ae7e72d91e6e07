#include <momentree/contact/shapes/cylinder_overlap.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <momentree/contact/candidates_impl.hpp>
#include <momentree/contact/shapes/circle.hpp>

namespace momentree::contact {

namespace {

constexpr double alongside = 0.9998;  // cosine of the angle of edges that touch the side along a line

bool in_outline(const Solid& solid, std::size_t plane, const Vec3& p) {
  return std::any_of(solid.faces.begin(), solid.faces.end(),
                     [&](const Solid::Face& face) { return at(face.plane) == plane && above_face(solid, face, p); });
}

// Of the outline of the faces of one plane.
bool is_of_outline(const Solid& solid, const Solid::Edge& edge, std::size_t plane) {
  return edge.faces[0] >= 0 &&
         (at(solid.faces[at(edge.faces[0])].plane) == plane || at(solid.faces[at(edge.faces[1])].plane) == plane);
}

struct CylinderOverlap {
  const Solid& can;
  const Place& of_can;
  const Solid& other;
  const Place& of_other;
  bool second;
  double within;
  std::vector<Candidate>& out;
  Vec3 axis = normalized(can.ends[1] - can.ends[0]);  // own
  double length = norm(can.ends[1] - can.ends[0]);
  Vec3 along = of_can.R * axis, centre = out_of(of_can, 0.5 * (can.ends[0] + can.ends[1]));  // world

  Vec3 outward(std::size_t end) const { return end == 0 ? -axis : axis; }

  // Of the cylinder above the other solid along a direction.
  double apart_along(const Vec3& n) const {
    const Vec3 own = transpose_times(of_other.R, n);
    double highest = -HUGE_VAL;
    for (const Vec3& v : other.vertices) highest = std::max(highest, dot(own, v));
    return lowest(n) - dot(n, of_other.r) - highest - other.radius;
  }
  double lowest(const Vec3& n) const {
    return dot(n, centre) - 0.5 * length * std::fabs(dot(n, along)) - can.rim * norm(cross(n, along));
  }

  enum class Kind : unsigned char { none, face, end, corner, side, rim };
  struct Direction {
    Kind kind = Kind::none;
    double gap = -HUGE_VAL;
    std::size_t of = 0, end = 0;
    double sign = 1;
  };
  static void better(Direction& best, const Direction& next) {
    if (next.gap > best.gap) best = next;
  }

  // The face or end that separates the solids best.
  Direction best_face() const {
    Direction best;
    for (std::size_t f = 0; f < other.faces.size(); ++f) {
      const Solid::Face& face = other.faces[f];
      if (at(face.plane) != f) continue;
      const Vec3 n = of_other.R * face.normal;
      better(best, {Kind::face, lowest(n) - dot(n, of_other.r) - face.offset - other.radius, f, 0, 1});
    }
    for (std::size_t end = 0; end < 2; ++end) better(best, {Kind::end, apart_along(-(of_can.R * outward(end))), 0, end, 1});
    return best;
  }

  // The edge or corner that separates them best, of those that are the outermost ones along their own normal.
  Direction best_edge() const {
    Direction best;
    const double slack = 1e-9 * (can.reach + other.reach);
    const auto look = [&](const Direction& d, bool can_first, const Features& f) {
      const Touch t = touch(f, can_first ? of_can : of_other, can_first ? of_other : of_can);
      if (!(t.gap > best.gap)) return;
      const double height = dot(along, t.point - centre);
      if (std::fabs(height) > 0.5 * length + slack) return;
      if (std::fabs(apart_along(can_first ? t.normal : -t.normal) - t.gap) < slack) best = d, best.gap = t.gap;
    };
    for (std::size_t i = 0; i < other.vertices.size(); ++i) look({Kind::corner, 0, i, 0, 1}, false, corner(i));
    for (std::size_t k = 0; k < other.edges.size(); ++k) {
      const Line line = line_of(other, other.edges[k]);
      const Vec3 to = of_other.R * line.along, from = out_of(of_other, line.from);
      if (norm(cross(along, to)) > parallel)
        for (const double sign : {1.0, -1.0}) look({Kind::side, 0, k, 0, sign}, true, before_side(line, sign));
      for (std::size_t end = 0; end < 2; ++end) {
        const Features f = before_rim(k, end);
        if (nearest_to_line(out_of(of_can, f.point_a) - from, of_can.R * f.line_a, f.rim, to, f.side > 0).found)
          look({Kind::rim, 0, k, end, 1}, true, f);
      }
    }
    return best;
  }

  Features corner(std::size_t vertex) const {
    Features f{FeaturePair::point_line, other.vertices[vertex], {}, can.ends[0], axis, other.radius, can.rim};
    return f;
  }
  Features before_rim(std::size_t edge, std::size_t end) const {
    const Line line = line_of(other, other.edges[edge]);
    Features f{FeaturePair::circle_line, can.ends[end], outward(end), line.from, line.along, 0, other.radius};
    f.rim = can.rim, f.side = std::fabs(dot(of_can.R * f.line_a, of_other.R * f.line_b)) < 0.5 ? 1 : 0;
    return f;
  }

  void push(bool can_first, const Features& f) const {
    const double gap = touch(f, can_first ? of_can : of_other, can_first ? of_other : of_can).gap;
    const bool swapped = can_first == second;
    if (gap < within) out.push_back({f, swapped, id_of(f.pair, swapped, out.size(), 0) | std::uint64_t{1} << 63, gap});
  }

  // Points of the cylinder before a face.
  void before_face(std::size_t plane) const {
    const Solid::Face& face = other.faces[plane];
    const Vec3 n = of_other.R * face.normal;
    const double upright = dot(n, along), tilt = norm(cross(n, along));
    const std::size_t end = upright > 0 ? 0 : 1, first = out.size();
    Features f{FeaturePair::circle_plane, can.ends[end], axis, other.vertices[at(face.corners[0])], face.normal, 0, other.radius};
    f.rim = can.rim;
    const Features lowest_of_rim = f;
    if (std::fabs(upright) < tilt) {
      // The lowest line of the side, as far as it is above the face: the lowest points of circles around the axis.
      std::array<Vec3, 2> low{};
      for (std::size_t e = 0; e < 2; ++e) f.point_a = can.ends[e], low[e] = into(of_other, touch(f, of_can, of_other).point);
      Part part{0, 1};
      clip(plane, low[0], low[1] - low[0], part);
      for (const double s : {part.from, part.to}) {
        if (part.from > part.to) break;
        f.point_a = can.ends[0] + s * (can.ends[1] - can.ends[0]);
        push(true, f);
      }
    } else {
      const Vec3 down = transpose_times(of_can.R, n), slope = down - dot(down, axis) * axis;
      std::array<Vec3, 2> across{};
      perpendiculars(axis, across.data());
      const bool stands = can.rim * tilt < standing;
      if (!stands) across[0] = -normalized(slope), across[1] = cross(axis, across[0]);
      for (std::size_t i = 0; i < points_of_rim; ++i) {
        const double angle = static_cast<double>(i) * 2 * std::numbers::pi / points_of_rim;
        const Vec3 p = can.ends[end] + can.rim * turned(across[0], across[1], angle);
        if (!in_outline(other, plane, into(of_other, out_of(of_can, p)))) continue;
        if (i == 0 && !stands)
          push(true, lowest_of_rim);
        else
          push_point(f, p);
      }
      // What the end has in common with the outline of the face, seen along the normal.
      const auto on_end = [&](const Vec3& v) {
        const Vec3 p = into(of_can, out_of(of_other, v));
        return p - (dot(p - can.ends[end], axis) / dot(down, axis)) * down;
      };
      for (const Solid::Edge& edge : other.edges) {
        if (!is_of_outline(other, edge, plane)) continue;
        const Vec3 a = on_end(other.vertices[at(edge.ends[0])]), b = on_end(other.vertices[at(edge.ends[1])]);
        const Part part = in_disc(a - can.ends[end], b - a, can.rim);
        if (part.from > part.to) continue;
        // A corner is an end of two edges: once is enough.
        if (part.from > 0 || is_first(edge, plane, 0)) push_point(f, a + part.from * (b - a));
        if (part.to < 1 || is_first(edge, plane, 1)) push_point(f, a + part.to * (b - a));
      }
    }
    if (out.size() == first) push(true, lowest_of_rim);
  }
  void push_point(Features f, const Vec3& p) const {
    f.pair = FeaturePair::point_plane, f.point_a = p, f.line_a = {}, f.rim = 0;
    push(true, f);
  }
  // The first edge of the outline of a plane with that corner.
  bool is_first(const Solid::Edge& edge, std::size_t plane, std::size_t k) const {
    const int corner = edge.ends[k];
    const auto of_corner = [&](const Solid::Edge& e) {
      return is_of_outline(other, e, plane) && (e.ends[0] == corner || e.ends[1] == corner);
    };
    return &*std::find_if(other.edges.begin(), other.edges.end(), of_corner) == &edge;
  }
  // The part of a segment, in the frame of the other solid, above the faces of a plane.
  void clip(std::size_t plane, const Vec3& p, const Vec3& d, Part& part) const {
    const Solid::Face& face = other.faces[plane];
    for (const Solid::Edge& edge : other.edges) {
      if (!is_of_outline(other, edge, plane)) continue;
      const bool first = at(other.faces[at(edge.faces[0])].plane) == plane;
      const Solid::Face& own = other.faces[at(edge.faces[first ? 0 : 1])];
      const Line line = line_of(other, edge);
      Vec3 inward = cross(face.normal, line.along), middle{};
      for (const int corner : own.corners) middle += other.vertices[at(corner)] - line.from;
      if (dot(inward, middle) < 0) inward = -inward;
      const double here = dot(inward, p - line.from), rate = dot(inward, d);
      if (rate > 0) part.from = std::max(part.from, -here / rate);
      if (rate < 0) part.to = std::min(part.to, -here / rate);
      if (rate == 0 && here < 0) part = {1, 0};
    }
  }

  // Points of the other solid before an end: of its face there, or the deepest one.
  void before_end(std::size_t end) const {
    const Vec3 own = transpose_times(of_other.R, of_can.R * outward(end));
    Features f{FeaturePair::point_plane, {}, {}, can.ends[end], outward(end), other.radius, 0};
    const std::size_t first = out.size();
    if (!other.faces.empty()) face_before_end(f, own, end);
    if (out.size() > first) return;
    f.point_a = *std::min_element(other.vertices.begin(), other.vertices.end(),
                                  [&](const Vec3& a, const Vec3& b) { return dot(own, a) < dot(own, b); });
    push(false, f);
  }
  void face_before_end(Features& f, const Vec3& own, std::size_t end) const {
    std::size_t plane = 0;
    for (std::size_t k = 1; k < other.faces.size(); ++k)
      if (dot(other.faces[k].normal, own) < dot(other.faces[plane].normal, own) - 1e-9) plane = k;
    plane = at(other.faces[plane].plane);
    const Solid::Face& face = other.faces[plane];
    const Vec3 local_axis = transpose_times(of_other.R, along), local_end = into(of_other, out_of(of_can, can.ends[end]));
    const auto flat = [&](const Vec3& v) { return v - dot(v, local_axis) * local_axis; };
    for (const Solid::Edge& edge : other.edges) {
      if (!is_of_outline(other, edge, plane)) continue;
      const Vec3 &a = other.vertices[at(edge.ends[0])], &b = other.vertices[at(edge.ends[1])];
      const Part part = in_disc(flat(a - local_end), flat(b - a), can.rim);
      if (part.from > part.to) continue;
      if (part.from > 0 || is_first(edge, plane, 0)) f.point_a = a + part.from * (b - a), push(false, f);
      if (part.to < 1 || is_first(edge, plane, 1)) f.point_a = a + part.to * (b - a), push(false, f);
    }
    std::array<Vec3, 2> across{};
    perpendiculars(axis, across.data());
    const double falling = dot(face.normal, local_axis);
    for (std::size_t i = 0; i < points_of_rim && std::fabs(falling) > 0.1; ++i) {
      const double angle = static_cast<double>(i) * 2 * std::numbers::pi / points_of_rim;
      const Vec3 p = can.ends[end] + can.rim * turned(across[0], across[1], angle);
      const Vec3 there = into(of_other, out_of(of_can, p));
      f.point_a = there - ((dot(face.normal, there) - face.offset) / falling) * local_axis;
      if (in_outline(other, plane, f.point_a)) push(false, f);
    }
  }

  // An edge that crosses the side or a rim, or a corner before the side; or an edge along the side.
  void at_edge(const Direction& best) const {
    std::size_t edge = best.of;
    if (best.kind == Kind::corner) edge = longest_along(best.of);
    if (edge < other.edges.size()) {
      const Line line = line_of(other, other.edges[edge]);
      const double cosine = dot(of_other.R * line.along, along);
      if (std::fabs(cosine) > alongside && best.kind != Kind::rim) return along_side(line, cosine, edge);
      if (best.kind == Kind::rim) return push(true, before_rim(edge, best.end));
      if (best.kind == Kind::side) return push(true, before_side(line, best.sign));
    }
    push(false, corner(best.of));
  }
  Features before_side(const Line& line, double sign) const {
    Features f{FeaturePair::line_line, can.ends[0], axis, line.from, line.along, can.rim, other.radius};
    f.side = sign;
    return f;
  }
  std::size_t longest_along(std::size_t corner) const {
    std::size_t found = other.edges.size();
    double most = alongside;
    for (std::size_t k = 0; k < other.edges.size(); ++k) {
      if (at(other.edges[k].ends[0]) != corner && at(other.edges[k].ends[1]) != corner) continue;
      const double cosine = std::fabs(dot(of_other.R * line_of(other, other.edges[k]).along, along));
      if (cosine > most) most = cosine, found = k;
    }
    return found;
  }
  // At the ends of what an edge and the side have in common, and where they are nearest.
  void along_side(const Line& line, double cosine, std::size_t edge) const {
    const Vec3 from = out_of(of_other, line.from);
    const double start = dot(along, from - centre) + 0.5 * length;  // heights along the axis
    double low = start, high = start + cosine * line.length;
    if (low > high) std::swap(low, high);
    low = std::clamp(low, 0.0, length), high = std::clamp(high, 0.0, length);
    Features f = before_rim(edge, 1);
    for (const double height : {low, high}) f.point_a = can.ends[0] + height * axis, push(true, f);
    const Vec3 n = cross(along, of_other.R * line.along);
    if (norm(n) < 1e-3) return;
    Features crossing = before_side(line, dot(n, centre - from) > 0 ? 1 : -1);
    const Along where = nearest_along(crossing, of_can, of_other);
    if (where.a > low && where.a < high) push(true, crossing);
  }

  void find() const {
    const Direction face = best_face();
    if (face.gap > within) return;
    const Direction edge = best_edge();
    const double more = nearly_parallel * std::min(can.thickness, other.thickness);
    if (edge.gap > within) return;
    if (edge.gap > std::max(clearly_less * face.gap, face.gap) + more) return at_edge(edge);
    if (face.kind == Kind::face) return before_face(face.of);
    before_end(face.end);
  }
};

}  // namespace

bool cylinder_overlaps(const Solid& cylinder, const Place& of_cylinder, const Solid& other, const Place& of_other) {
  const Vec3 axis = normalized(cylinder.ends[1] - cylinder.ends[0]);
  const double length = norm(cylinder.ends[1] - cylinder.ends[0]);
  // An edge passes through the cylinder.
  for (const Solid::Edge& edge : other.edges) {
    const Vec3 a = into(of_cylinder, out_of(of_other, other.vertices[at(edge.ends[0])])) - cylinder.ends[0];
    const Vec3 b = into(of_cylinder, out_of(of_other, other.vertices[at(edge.ends[1])])) - cylinder.ends[0];
    const double ha = dot(a, axis), rate = dot(b, axis) - ha;
    const Vec3 pa = a - ha * axis, d = b - a - rate * axis;
    Part part = in_disc(pa, d, cylinder.rim);
    if (rate != 0) {
      const double low = -ha / rate, high = (length - ha) / rate;
      part.from = std::max(part.from, std::min(low, high)), part.to = std::min(part.to, std::max(low, high));
    } else if (ha < 0 || ha > length) {
      continue;
    }
    if (part.from <= part.to) return true;
  }
  if (other.faces.empty()) return false;
  // A face cuts it.
  const Vec3 centre = into(of_other, out_of(of_cylinder, 0.5 * (cylinder.ends[0] + cylinder.ends[1])));
  const Vec3 along = transpose_times(of_other.R, of_cylinder.R * axis);
  bool inside = true;
  for (std::size_t f = 0; f < other.faces.size(); ++f) {
    const Solid::Face& face = other.faces[f];
    const double above = dot(face.normal, centre) - face.offset, upright = dot(face.normal, along);
    const Vec3 slope = face.normal - upright * along;
    const double tilt = norm(slope);
    const Vec3 up = (upright > 0 ? 0.5 * length : -0.5 * length) * along + (tilt > 0 ? cylinder.rim / tilt : 0.0) * slope;
    const double half = dot(face.normal, up);
    inside = inside && above <= 0;
    if (std::fabs(above) > half || at(face.plane) != f) continue;
    if (in_outline(other, f, centre - (half > 0 ? above / half : 0.0) * up)) return true;
  }
  return inside;
}

void cylinder_overlap_points(const Solid& cylinder, const Place& of_cylinder, const Solid& other, const Place& of_other,
                             bool second, double within, std::vector<Candidate>& out) {
  CylinderOverlap{cylinder, of_cylinder, other, of_other, second, within, out}.find();
}

}  // namespace momentree::contact
