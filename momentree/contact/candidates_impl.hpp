#pragma once
// Vertices, edges and faces of solids. Included only by the files that find features that face each other.
#include <algorithm>
#include <cmath>
#include <vector>

#include <momentree/contact/candidates.hpp>
#include <momentree/contact/indices.hpp>

namespace momentree::contact {

inline constexpr double parallel = 1e-6;    // sine of the angle of edges that do not cross
inline constexpr double edge_slack = 1e-9;  // what is this near the outline of a face is above it; relative to the solid's size

// Faces give several points, edges one: an edge is taken only if the overlap along it is clearly less. Between faces that are
// nearly parallel, edges and faces differ by rounding, and bodies that rest would lose all points but one.
inline constexpr double clearly_less = 0.9;
inline constexpr double nearly_parallel = 3e-5;  // of the thickness of the thinner solid

inline std::uint64_t id_of(FeaturePair pair, bool swapped, std::size_t a, std::size_t b) {
  return static_cast<std::uint64_t>(pair) | (swapped ? 8u : 0u) | static_cast<std::uint64_t>(a) << 4 |
         static_cast<std::uint64_t>(b) << 34;
}

inline Vec3 into(const Place& place, const Vec3& world) { return transpose_times(place.R, world - place.r); }
inline Vec3 out_of(const Place& place, const Vec3& own) { return place.r + place.R * own; }

struct Line {
  Vec3 from, along;
  double length;
};
inline Line line_of(const Solid& solid, const Solid::Edge& edge) {
  const Vec3 &a = solid.vertices[at(edge.ends[0])], &b = solid.vertices[at(edge.ends[1])];
  const double length = norm(b - a);
  return {a, (1 / length) * (b - a), length};
}

inline bool above_face(const Solid& solid, const Solid::Face& face, const Vec3& p) {
  const double slack = edge_slack * solid.reach;
  for (std::size_t k = 0; k < face.corners.size(); ++k) {
    const Vec3 &a = solid.vertices[at(face.corners[k])], &b = solid.vertices[at(face.corners[(k + 1) % face.corners.size()])];
    if (dot(cross(face.normal, b - a), p - a) < -slack * norm(b - a)) return false;
  }
  return true;
}

// The face that is the least below, or the most above, a point; −1: a solid without faces. Faces from which edges of the point
// lead inward count only if the point is above them: then it is not before another face.
struct Height {
  int face = -1;
  double above = -HUGE_VAL;
};
inline Height over_faces(const Solid& solid, const Vec3& p, const std::vector<Vec3>& edges) {
  Height found;
  const double slack = edge_slack * solid.reach;
  for (std::size_t f = 0; f < solid.faces.size(); ++f) {
    const Solid::Face& face = solid.faces[f];
    const double above = dot(face.normal, p) - face.offset;
    bool inward = false;
    for (const Vec3& edge : edges) inward = inward || dot(face.normal, edge) < -0.1;
    if (inward && above <= slack) continue;
    if (above < found.above - slack) continue;
    // Of equal ones, such as triangles of one plane, that under the point.
    const bool equal = found.face >= 0 && above <= found.above + slack;
    if (equal && above_face(solid, solid.faces[at(found.face)], p)) continue;
    found = {static_cast<int>(f), above};
  }
  return found;
}

// The direction `outward` leaves a solid at an edge between the directions of its faces.
inline bool leaves(const Solid& solid, const Place& place, const Solid::Edge& edge, const Line& line, const Vec3& outward,
                   double slack = 1e-9) {
  if (edge.faces[0] < 0) return true;
  const Vec3 own = transpose_times(place.R, outward);
  for (const int f : edge.faces) {
    // From the edge into the face.
    Vec3 inward = cross(solid.faces[at(f)].normal, line.along);
    Vec3 middle{};
    for (const int corner : solid.faces[at(f)].corners) middle += solid.vertices[at(corner)] - line.from;
    if (dot(inward, middle) < 0) inward = -inward;
    if (dot(own, inward) > slack) return false;
  }
  return true;
}

struct Part {
  double from, to;  // of a line, within 0 and 1; empty if from > to
};
// The part of the segment p + s d within the circle of that radius around zero, all in its plane.
inline Part in_disc(const Vec3& p, const Vec3& d, double radius) {
  const double a = dot(d, d), b = dot(p, d), c = dot(p, p) - radius * radius;
  if (!(a > 0)) return c <= 0 ? Part{0, 1} : Part{1, 0};
  const double square = b * b - a * c;
  if (square < 0) return {1, 0};
  const double root = std::sqrt(square);
  return {std::max(0.0, (-b - root) / a), std::min(1.0, (-b + root) / a)};
}

}  // namespace momentree::contact
