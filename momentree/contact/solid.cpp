#include <momentree/contact/solid.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <momentree/contact/indices.hpp>

namespace momentree::contact {

namespace {

// Edges from the corners of the faces, less those between faces of one plane.
void find_edges(Solid& solid) {
  std::map<std::pair<int, int>, std::array<int, 2>> sides;
  for (std::size_t f = 0; f < solid.faces.size(); ++f) {
    const std::vector<int>& corners = solid.faces[f].corners;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const int a = corners[k], b = corners[(k + 1) % corners.size()];
      std::array<int, 2>& of = sides.try_emplace({std::min(a, b), std::max(a, b)}, std::array{-1, -1}).first->second;
      of[of[0] < 0 ? 0 : 1] = static_cast<int>(f);
    }
  }
  for (const auto& [ends, faces] : sides) {
    if (faces[0] < 0 || faces[1] < 0) continue;
    if (norm(cross(solid.faces[at(faces[0])].normal, solid.faces[at(faces[1])].normal)) < 1e-9) continue;
    solid.edges.push_back({{ends.first, ends.second}, {faces[0], faces[1]}});
  }
}

void find_reach(Solid& solid) {
  solid.along.resize(solid.vertices.size());
  for (const Solid::Edge& edge : solid.edges) {
    const Vec3 from = normalized(solid.vertices[at(edge.ends[1])] - solid.vertices[at(edge.ends[0])]);
    solid.along[at(edge.ends[0])].push_back(from), solid.along[at(edge.ends[1])].push_back(-from);
  }
  Vec3 low = solid.vertices.front(), high = low;
  for (const Vec3& v : solid.vertices) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
  }
  solid.centre = 0.5 * (low + high);
  for (const Vec3& v : solid.vertices) solid.reach = std::max(solid.reach, norm(v - solid.centre));
  solid.reach += solid.radius;
  // The least width across a face.
  double width = HUGE_VAL;
  for (const Solid::Face& face : solid.faces) {
    double deepest = 0;
    for (const Vec3& v : solid.vertices) deepest = std::max(deepest, face.offset - dot(face.normal, v));
    width = std::min(width, deepest);
  }
  solid.thickness = 2 * solid.radius + (std::isfinite(width) ? width : 0.0);
}

Solid::Face face_of(const std::vector<Vec3>& vertices, std::vector<int> corners) {
  Solid::Face face;
  const Vec3 &a = vertices[at(corners[0])], &b = vertices[at(corners[1])], &c = vertices[at(corners[2])];
  face.normal = normalized(cross(b - a, c - a));
  face.offset = dot(face.normal, a);
  face.corners = std::move(corners);
  return face;
}

// Four points that are far from lying in a plane, or none.
std::vector<int> first_tetrahedron(std::span<const Vec3> points, double size) {
  const auto farthest = [&](auto distance) {
    int best = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
      if (distance(points[i]) > distance(points[at(best)])) best = static_cast<int>(i);
    return best;
  };
  const int a = farthest([&](const Vec3& p) { return -p.x; });
  const Vec3 pa = points[at(a)];
  const int b = farthest([&](const Vec3& p) { return norm(p - pa); });
  const Vec3 ab = points[at(b)] - pa;
  if (!(norm(ab) > 1e-9 * size)) return {};
  const int c = farthest([&](const Vec3& p) { return norm(cross(p - pa, ab)); });
  const Vec3 normal = cross(ab, points[at(c)] - pa);
  if (!(norm(normal) > 1e-9 * size * size)) return {};
  const int d = farthest([&](const Vec3& p) { return std::fabs(dot(p - pa, normal)); });
  const double height = dot(points[at(d)] - pa, normal);
  if (!(std::fabs(height) > 1e-9 * size * norm(normal))) return {};
  return height > 0 ? std::vector{a, c, b, d} : std::vector{a, b, c, d};
}

// Points are added one by one: the faces that a point sees are replaced by triangles from their outline to the point.
std::vector<std::array<int, 3>> triangles_of_hull(std::span<const Vec3> points, double size) {
  const std::vector<int> start = first_tetrahedron(points, size);
  if (start.empty()) return {};
  struct Triangle {
    std::array<int, 3> corners;
    Vec3 normal;
    double offset;
  };
  const auto make = [&](int a, int b, int c) {
    const Vec3 n = normalized(cross(points[at(b)] - points[at(a)], points[at(c)] - points[at(a)]));
    return Triangle{{a, b, c}, n, dot(n, points[at(a)])};
  };
  const int a = start[0], b = start[1], c = start[2], d = start[3];
  std::vector<Triangle> all{make(a, b, c), make(a, d, b), make(b, d, c), make(c, d, a)};
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::set<std::pair<int, int>> outline;
    std::vector<Triangle> kept;
    for (const Triangle& t : all) {
      if (dot(t.normal, points[i]) - t.offset <= 1e-12 * size) {
        kept.push_back(t);
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const std::pair side{t.corners[k], t.corners[(k + 1) % 3]};
        if (outline.erase({side.second, side.first}) == 0) outline.insert(side);
      }
    }
    for (const auto& [from, to] : outline) {
      const Vec3 n = cross(points[at(to)] - points[at(from)], points[i] - points[at(from)]);
      if (norm(n) > 0) kept.push_back(make(from, to, static_cast<int>(i)));
    }
    all = std::move(kept);
  }
  std::vector<std::array<int, 3>> corners;
  for (const Triangle& t : all) corners.push_back(t.corners);
  return corners;
}

}  // namespace

Solid sphere(double radius, const Pose& at_pose) {
  Solid solid;
  solid.vertices = {at_pose.position}, solid.radius = radius;
  find_reach(solid);
  return solid;
}

Solid capsule(double radius, double length, const Pose& at_pose) {
  Solid solid;
  solid.vertices = {at_pose * Vec3{0, 0, -length / 2}, at_pose * Vec3{0, 0, length / 2}}, solid.radius = radius;
  solid.edges = {{{0, 1}, {-1, -1}}};
  find_reach(solid);
  return solid;
}

Solid box(const Vec3& size, const Pose& at_pose) {
  Solid solid;
  for (int i = 0; i < 8; ++i)
    solid.vertices.push_back(at_pose * Vec3{(i & 1) != 0 ? size.x / 2 : -size.x / 2, (i & 2) != 0 ? size.y / 2 : -size.y / 2,
                                            (i & 4) != 0 ? size.z / 2 : -size.z / 2});
  for (const auto& corners : {std::vector{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}})
    solid.faces.push_back(face_of(solid.vertices, corners));
  find_edges(solid);
  find_reach(solid);
  return solid;
}

Solid hull(std::span<const Vec3> points) {
  Solid solid;
  if (points.size() < 4) return solid;
  double size = 0;
  for (const Vec3& p : points) size = std::max(size, norm(p - points[0]));
  std::map<int, int> number;
  for (std::array<int, 3> corners : triangles_of_hull(points, size)) {
    for (int& corner : corners) {
      const auto [found, first] = number.try_emplace(corner, static_cast<int>(solid.vertices.size()));
      if (first) solid.vertices.push_back(points[at(corner)]);
      corner = found->second;
    }
    solid.faces.push_back(face_of(solid.vertices, {corners[0], corners[1], corners[2]}));
  }
  if (solid.vertices.empty()) return solid;
  find_edges(solid);
  find_reach(solid);
  return solid;
}

}  // namespace momentree::contact
