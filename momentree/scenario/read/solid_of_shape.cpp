// What shapes touch with; meshes as their convex hulls, or as convex parts.
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/models/import/solid_mesh.hpp>
#include <momentree/models/mesh/split.hpp>
#include <momentree/scenario/scenario_parts.hpp>

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

void warn_of_corners(const std::string& name, double beyond, const ReportOnShape& warn) {
  if (!(beyond > 0)) return;
  char depth[32];
  std::snprintf(depth, sizeof depth, "%.2g", beyond);
  warn(name + " has many corners: " + std::to_string(most_hull_corners) + " of them touch, and others are up to " + depth +
           " m outside of their hull",
       "simplify it to choose which");
}

std::vector<contact::Solid> parts_of([[maybe_unused]] const MeshPart& mesh, [[maybe_unused]] const Shape& shape,
                                     const std::string& name, const ShapeReports& report) {
#ifdef __cpp_exceptions
  const std::shared_ptr<const SplitMesh> split = split_mesh(mesh, shape.split);
  if (!split->problem.empty()) {
    report.fail(name + " " + split->problem, split->hint);
    return {};
  }
  std::vector<contact::Solid> solids;
  double farthest = 0;
  for (const std::vector<Vec3>& part : split->parts) {
    double beyond = 0;
    contact::Solid hull = contact::hull_within(moved(part, shape.at), most_hull_corners, hull_tolerance, beyond);
    if (hull.vertices.empty()) continue;
    farthest = std::max(farthest, beyond);
    solids.push_back(std::move(hull));
  }
  warn_of_corners("a part of " + name, farthest, report.warn);
  return solids;
#else
  report.fail(name + " cannot be split in a browser", "touch with boxes, spheres, capsules or cylinders");
  return {};
#endif
}

std::vector<contact::Solid> solids_of_mesh(const Shape& shape, const ShapeReports& report) {
  const std::string name = shape.mesh.empty() ? std::string("the mesh") : "the mesh " + in_quotes(shape.mesh);
  const std::optional<MeshPart> mesh = mesh_of(shape, name, report.refuse);
  if (!mesh) return {};
  const std::vector<Vec3> points = moved(mesh->points, shape.at);
  double beyond = 0;
  contact::Solid hull = contact::hull_within(points, most_hull_corners, hull_tolerance, beyond);
  if (hull.vertices.empty()) {
    report.refuse(name + " is flat", "a collider has a volume: use a thin box");
    return {};
  }
  const std::optional<double> own = volume_of(points, mesh->triangles);
  const bool closed = own && is_closed(points, mesh->triangles);
  if (shape.split > 0 && closed) return parts_of(*mesh, shape, name, report);
  warn_of_corners(name, beyond, report.warn);
  const double whole = contact::volume(hull);
  if (own && *own >= concave * whole) return {std::move(hull)};
  if (!closed)
    (shape.split > 0 ? report.unclosed : report.warn)(name + " is not closed: its hull touches",
                                                      "close it, or let boxes, spheres, capsules or cylinders touch");
  else
    report.warn(name + " is not convex: its hull touches, of which it fills " + percent(*own / whole),
                "split = 0.05 divides it into convex parts; of a model file, in its mechanism");
  return {std::move(hull)};
}

}  // namespace

std::vector<contact::Solid> solids_of(const Shape& shape, const ShapeReports& report) {
  switch (shape.kind) {
    case Shape::Kind::primitive:
      if (contact::has_volume(shape.primitive)) return {contact::solid(shape.primitive, shape.at)};
      report.refuse("a shape without volume", "its sizes must be greater than 0");
      break;
    case Shape::Kind::mesh: return solids_of_mesh(shape, report);
    case Shape::Kind::plane: report.refuse("a plane of a body that moves", "a plane belongs to the ground: use a box"); break;
    case Shape::Kind::heights:
      report.refuse("a height field of a body that moves", "a height field belongs to the ground: use a mesh");
      break;
    case Shape::Kind::none: break;
  }
  return {};
}

}  // namespace momentree::io
