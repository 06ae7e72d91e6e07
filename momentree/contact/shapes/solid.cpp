#include <momentree/contact/shapes/solid.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include <momentree/contact/indices.hpp>
#include <momentree/contact/primitives/declaration.hpp>
#include <momentree/contact/shapes/feature.hpp>
#include <momentree/contact/shapes/quick_hull.hpp>
#include <momentree/math/sine_cosine.hpp>

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
  for (std::size_t f = 0; f < solid.faces.size(); ++f) {
    Solid::Face& face = solid.faces[f];
    const auto same = [&](const Solid::Face& first) {
      return norm(first.normal - face.normal) < 1e-9 && std::fabs(first.offset - face.offset) < 1e-9 * solid.reach;
    };
    const auto first = std::find_if(solid.faces.begin(), solid.faces.begin() + static_cast<std::ptrdiff_t>(f), same);
    face.plane = static_cast<int>(first - solid.faces.begin());
  }
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

// `inner`, `outer`: radii of balls in it and around it.
Solid smooth(const Vec3& sizes, double inner, double outer, const Pose& at_pose) {
  Solid solid = sphere(inner, at_pose);
  solid.reach = outer;
  const Mat3 R = rotation_matrix(at_pose.rotation);
  solid.axes = {R * Vec3{sizes.x, 0, 0}, R * Vec3{0, sizes.y, 0}, R * Vec3{0, 0, sizes.z}};
  return solid;
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

Solid ellipsoid(const Vec3& semi_axes, const Pose& at_pose) {
  const auto [least, most] = std::minmax({semi_axes.x, semi_axes.y, semi_axes.z});
  return smooth(semi_axes, least, most, at_pose);
}

Solid smooth_solid(const SmoothSurface& surface, const Vec3& sizes, const Pose& at_pose) {
  const Axes axes{Vec3{sizes.x, 0, 0}, {0, sizes.y, 0}, {0, 0, sizes.z}};
  double inner = HUGE_VAL, outer = 0;
  for (const Vec3& n : directions(32)) {
    const Vec3 x = surface.farthest(axes, n);
    inner = std::min(inner, dot(n, x)), outer = std::max(outer, norm(x));
  }
  return smooth(sizes, inner, 1.01 * outer, at_pose);  // it may reach farther between these directions
}

std::vector<Vec3> directions(int around) {
  std::vector<Vec3> all;
  const int down = around / 2;
  for (int i = 0; i <= down; ++i)
    for (int k = 0; k < (i == 0 || i == down ? 1 : around); ++k) {
      const auto [sine, cosine] = sine_cosine(std::numbers::pi * i / down);
      const auto [y, x] = sine_cosine(2 * std::numbers::pi * k / around);
      all.push_back({sine * x, sine * y, cosine});
    }
  return all;
}

Solid cylinder(double radius, double length, const Pose& at_pose) {
  Solid solid;
  // Edges outside by as much as the sides are inside.
  constexpr double step = 2 * std::numbers::pi / cylinder_sides;
  const double edge = 2 * radius / (1 + sine_cosine(step / 2).c);
  std::vector<int> low, high;
  for (int k = 0; k < cylinder_sides; ++k) {
    const auto [s, c] = sine_cosine(k * step);
    const Vec3 across{edge * c, edge * s, 0};
    low.insert(low.begin(), 2 * k), high.push_back(2 * k + 1);
    for (const double z : {-length / 2, length / 2}) solid.vertices.push_back(at_pose * (across + Vec3{0, 0, z}));
    const int next = (k + 1) % cylinder_sides;
    solid.faces.push_back({{}, 0, {2 * k, 2 * next, 2 * next + 1, 2 * k + 1}});
  }
  solid.faces.push_back({{}, 0, low}), solid.faces.push_back({{}, 0, high});
  for (Solid::Face& face : solid.faces) face = face_of(solid.vertices, std::move(face.corners));
  find_edges(solid);
  find_reach(solid);
  solid.rim = radius, solid.ends = {at_pose * Vec3{0, 0, -length / 2}, at_pose * Vec3{0, 0, length / 2}};
  return solid;
}

Solid hull(std::span<const Vec3> points) {
  double beyond = 0;
  return hull_within(points, std::numeric_limits<std::size_t>::max(), 1e-12, beyond);
}

Solid hull_within(std::span<const Vec3> points, std::size_t most, double tolerance, double& beyond) {
  Solid solid;
  const Hull found = quick_hull(points, tolerance, most);
  beyond = found.beyond;
  std::map<int, int> number;
  for (std::array<int, 3> corners : found.triangles) {
    for (int& corner : corners) {
      const auto [known, first] = number.try_emplace(corner, static_cast<int>(solid.vertices.size()));
      if (first) solid.vertices.push_back(points[at(corner)]);
      corner = known->second;
    }
    solid.faces.push_back(face_of(solid.vertices, {corners[0], corners[1], corners[2]}));
  }
  if (solid.vertices.empty()) return solid;
  find_edges(solid);
  find_reach(solid);
  return solid;
}

double volume(const Solid& solid) {
  double six = 0;
  for (const Solid::Face& face : solid.faces)
    for (std::size_t k = 2; k < face.corners.size(); ++k) {
      const Vec3 &a = solid.vertices[at(face.corners[0])], &b = solid.vertices[at(face.corners[k - 1])];
      six += dot(a - solid.centre, cross(b - solid.centre, solid.vertices[at(face.corners[k])] - solid.centre));
    }
  return six / 6;
}

Pose placed_along_z(const Vec3& from, const Vec3& to) {
  const Vec3 z = normalized(to - from);
  Vec3 across[2];
  perpendiculars(z, across);
  return {0.5 * (from + to), rotation_from_axes(across[0], across[1], z)};
}

}  // namespace momentree::contact
