#include <momentree/models/import/solid_mesh.hpp>

#include <algorithm>
#include <map>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/contact/uniform_mass.hpp>
#include <momentree/models/mesh/read_mesh.hpp>
#include <momentree/models/mesh/source.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

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

std::optional<MeshPart> mesh_of(const Shape& shape, const std::string& name, const ReportOnShape& refuse) {
  if (!shape.source) {
    refuse(name + " cannot be read", "keep it in the folder of the file that names it");
    return std::nullopt;
  }
  MeshPart whole;
  const auto add = [&](const MeshPart& part) {
    const auto first = static_cast<std::uint32_t>(whole.points.size());
    for (const Vec3& p : part.points) whole.points.push_back({shape.scale.x * p.x, shape.scale.y * p.y, shape.scale.z * p.z});
    for (const auto& [a, b, c] : part.triangles) whole.triangles.push_back({first + a, first + b, first + c});
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
  return whole;
}

std::vector<Vec3> moved(std::vector<Vec3> points, const Pose& at) {
  for (Vec3& p : points) p = at * p;
  return points;
}

std::optional<MassProperties> mass_of(const Shape& shape, double density, const ReportOnShape& refuse) {
  if (shape.kind == Shape::Kind::primitive) return mass_properties(shape.primitive, shape.at, density);
  if (shape.kind != Shape::Kind::mesh) {
    refuse("a plane has no volume", "give mass and inertia");
    return std::nullopt;
  }
  const std::string name = shape.mesh.empty() ? "the mesh" : "the mesh " + in_quotes(shape.mesh);
  const std::optional<MeshPart> mesh = mesh_of(shape, name, refuse);
  if (!mesh) return std::nullopt;
  const MassProperties mass = mass_properties(moved(mesh->points, shape.at), mesh->triangles, density);
  if (is_closed(mesh->points, mesh->triangles) && mass.mass > 0) return mass;
  refuse(name + " is not closed, and has no volume", "give mass and inertia, or close it");
  return std::nullopt;
}

}  // namespace momentree::io
