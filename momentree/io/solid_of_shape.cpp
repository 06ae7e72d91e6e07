// What shapes touch with; meshes as their convex hulls.
#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/io/mesh/read_mesh.hpp>
#include <momentree/io/mesh/source.hpp>
#include <momentree/io/scenario_parts.hpp>

namespace momentree::io {

namespace {

constexpr std::size_t most_hull_corners = 64;
constexpr double hull_tolerance = 1e-6;  // relative to its size
constexpr double concave = 0.95;         // of the hull's volume

std::string percent(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g %%", 100 * x);
  return text;
}

// Volume of a mesh, or nothing if it is not closed.
std::optional<double> volume_of(const std::vector<Vec3>& points, const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  double six = 0, area = 0;
  Vec3 sum{};
  for (const auto& [i, j, k] : triangles) {
    const Vec3 &a = points[i], b = points[j] - a, c = points[k] - a, twice = cross(b, c);
    six += dot(a - points[0], twice), area += norm(twice), sum += twice;
  }
  if (norm(sum) > 1e-4 * area) return std::nullopt;
  return std::fabs(six) / 6;
}

// True if each edge belongs to an even number of triangles. Corners of different triangles are the same if they coincide.
bool is_closed(const std::vector<Vec3>& points, const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::map<std::array<double, 3>, int> corners;
  std::vector<int> corner;
  for (const Vec3& p : points)
    corner.push_back(corners.try_emplace({p.x, p.y, p.z}, static_cast<int>(corners.size())).first->second);
  std::map<std::pair<int, int>, bool> open;
  for (const auto& triangle : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = corner[triangle[k]], b = corner[triangle[(k + 1) % 3]];
      if (a == b) continue;
      bool& edge = open[std::minmax(a, b)];
      edge = !edge;
    }
  return std::all_of(open.begin(), open.end(), [](const auto& edge) { return !edge.second; });
}

std::optional<contact::Solid> hull_of(const Shape& shape, const ReportOnShape& refuse, const ReportOnShape& warn) {
  const std::string name = shape.mesh.empty() ? std::string("the mesh") : "the mesh " + in_quotes(shape.mesh);
  if (!shape.source) {
    refuse(name + " cannot be read", "keep it in the folder of the file that names it");
    return std::nullopt;
  }
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const auto add = [&](const MeshPart& part) {
    const auto first = static_cast<std::uint32_t>(points.size());
    for (const Vec3& p : part.points)
      points.push_back(shape.at * Vec3{shape.scale.x * p.x, shape.scale.y * p.y, shape.scale.z * p.z});
    for (const auto& [a, b, c] : part.triangles) triangles.push_back({first + a, first + b, first + c});
  };
  if (shape.source->path.empty()) {
    add(shape.source->inside);
  } else {
#ifdef __cpp_exceptions
    try {
      for (const MeshPart& part : read_mesh_file(shape.source->path, shape.source->submesh).parts) add(part);
    } catch (const Error& error) {
      refuse(name + ": " + error.problem, error.hint);
      return std::nullopt;
    }
#else  // the engine for browsers has no files
    refuse(name + " cannot be read in a browser", "touch with boxes, spheres, capsules or cylinders, or run it with the command");
    return std::nullopt;
#endif
  }
  double beyond = 0;
  contact::Solid hull = contact::hull_within(points, most_hull_corners, hull_tolerance, beyond);
  if (hull.vertices.empty()) {
    refuse(name + " is flat", "a collider has a volume: use a thin box");
    return std::nullopt;
  }
  if (beyond > 0) {
    char depth[32];
    std::snprintf(depth, sizeof depth, "%.2g", beyond);
    warn(name + " has many corners: " + std::to_string(most_hull_corners) + " of them touch, and others are up to " + depth +
             " m outside of their hull",
         "simplify it to choose which");
  }
  const std::optional<double> own = volume_of(points, triangles);
  const double whole = contact::volume(hull);
  if (own && *own >= concave * whole) return hull;
  if (!own || !is_closed(points, triangles))
    warn(name + " is not closed: its hull touches", "close it, or let boxes, spheres, capsules or cylinders touch");
  else
    warn(name + " is not convex: its hull touches, of which it fills " + percent(*own / whole), "divide it into convex shapes");
  return hull;
}

}  // namespace

std::optional<contact::Solid> solid_of(const Shape& shape, const ReportOnShape& refuse, const ReportOnShape& warn) {
  const bool by_size = shape.kind == Shape::Kind::box || shape.kind == Shape::Kind::ellipsoid;
  const bool has_size = by_size ? shape.size.x > 0 && shape.size.y > 0 && shape.size.z > 0
                        : shape.kind == Shape::Kind::mesh || is_of_ground(shape.kind) ? true
                                                                                      : shape.radius > 0;
  if (!has_size || (shape.kind == Shape::Kind::cylinder && !(shape.length > 0))) {
    refuse("a shape without volume", "its sizes must be greater than 0");
    return std::nullopt;
  }
  switch (shape.kind) {
    case Shape::Kind::sphere: return contact::sphere(shape.radius, shape.at);
    case Shape::Kind::capsule:
      return shape.length > 0 ? contact::capsule(shape.radius, shape.length, shape.at) : contact::sphere(shape.radius, shape.at);
    case Shape::Kind::cylinder: return contact::cylinder(shape.radius, shape.length, shape.at);
    case Shape::Kind::box: return contact::box(shape.size, shape.at);
    case Shape::Kind::ellipsoid: return contact::ellipsoid(shape.size, shape.at);
    case Shape::Kind::mesh: return hull_of(shape, refuse, warn);
    case Shape::Kind::plane: refuse("a plane of a body that moves", "a plane belongs to the ground: use a box"); break;
    case Shape::Kind::heights:
      refuse("a height field of a body that moves", "a height field belongs to the ground: use a mesh");
      break;
    case Shape::Kind::none: break;
  }
  return std::nullopt;
}

}  // namespace momentree::io
