#include <momentree/export/triangles.hpp>

#include <cmath>
#include <numbers>

namespace momentree::io {

namespace {

constexpr std::uint32_t around = 24;  // points around an axis

void add_point(Triangles& mesh, const Vec3& position, const Vec3& normal) {
  for (const double x : {position.x, position.y, position.z}) mesh.positions.push_back(static_cast<float>(x));
  for (const double x : {normal.x, normal.y, normal.z}) mesh.normals.push_back(static_cast<float>(x));
}

std::uint32_t points_in(const Triangles& mesh) { return static_cast<std::uint32_t>(mesh.positions.size() / 3); }

/// A point of the unit circle, exactly the same at both ends of the turn.
Vec3 on_circle(std::uint32_t k) {
  const double angle = 2 * std::numbers::pi * (k % around) / around;
  return {std::cos(angle), std::sin(angle), 0};
}

/// A circle of points at this height, whose normals rise by `sine`.
void add_ring(Triangles& mesh, double radius, double z, double sine) {
  const double cosine = std::sqrt(1 - sine * sine);
  for (std::uint32_t k = 0; k < around; ++k) {
    const Vec3 out = on_circle(k);
    add_point(mesh, {radius * out.x, radius * out.y, z}, {cosine * out.x, cosine * out.y, sine});
  }
}

/// The surface between two rings of points, the upper of which begins at `upper`.
void join_rings(Triangles& mesh, std::uint32_t lower, std::uint32_t upper) {
  for (std::uint32_t k = 0; k < around; ++k) {
    const std::uint32_t next = (k + 1) % around;
    for (const std::uint32_t i : {lower + k, lower + next, upper + next, lower + k, upper + next, upper + k})
      mesh.indices.push_back(i);
  }
}

/// The surface between a ring and a point: above it, or below it.
void join_pole(Triangles& mesh, std::uint32_t ring, std::uint32_t pole, bool above) {
  for (std::uint32_t k = 0; k < around; ++k) {
    const std::uint32_t next = (k + 1) % around;
    const std::uint32_t first = above ? ring + k : ring + next, second = above ? ring + next : ring + k;
    for (const std::uint32_t i : {first, second, pole}) mesh.indices.push_back(i);
  }
}

/// Half spheres at both ends of a cylinder of this length; of length zero: a sphere.
Triangles rounded(double radius, double length) {
  constexpr int rings = 6;  // of each half
  Triangles mesh;
  add_point(mesh, {0, 0, -radius - 0.5 * length}, {0, 0, -1});
  std::uint32_t before = 0;
  for (int half = 0; half < 2; ++half)
    for (int i = half == 0 ? 1 : 0; i < (half == 0 ? rings + 1 : rings); ++i) {
      if (half == 1 && i == 0 && length == 0) continue;  // it is the last ring of the lower half
      const double angle = 0.5 * std::numbers::pi * (half == 0 ? i - rings : i) / rings;
      const double sine = std::sin(angle), cosine = std::cos(angle);
      const std::uint32_t ring = points_in(mesh);
      add_ring(mesh, radius * cosine, radius * sine + (half == 0 ? -0.5 : 0.5) * length, sine);
      before == 0 ? join_pole(mesh, ring, 0, false) : join_rings(mesh, before, ring);
      before = ring;
    }
  const std::uint32_t pole = points_in(mesh);
  add_point(mesh, {0, 0, radius + 0.5 * length}, {0, 0, 1});
  join_pole(mesh, before, pole, true);
  return mesh;
}

}  // namespace

Triangles unit_box() {
  Triangles mesh;
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (std::size_t k = 0; k < 3; ++k)
    for (const double side : {-1.0, 1.0}) {
      const Vec3 normal = side * axes[k], u = axes[(k + 1) % 3], v = side * axes[(k + 2) % 3];
      const std::uint32_t first = points_in(mesh);
      for (const auto& [a, b] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}})
        add_point(mesh, 0.5 * normal + a * u + b * v, normal);
      for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + i);
    }
  return mesh;
}

Triangles unit_sphere() { return rounded(0.5, 0); }
Triangles capsule_of(double radius, double length) { return rounded(radius, length); }

Triangles unit_cylinder() {
  Triangles mesh;
  add_ring(mesh, 0.5, -0.5, 0);
  add_ring(mesh, 0.5, 0.5, 0);
  join_rings(mesh, 0, around);
  for (const double side : {-1.0, 1.0}) {
    const std::uint32_t ring = points_in(mesh);
    add_ring(mesh, 0.5, 0.5 * side, side);
    const std::uint32_t middle = points_in(mesh);
    add_point(mesh, {0, 0, 0.5 * side}, {0, 0, side});
    join_pole(mesh, ring, middle, side > 0);
  }
  return mesh;
}

Triangles triangles_of(const MeshPart& part) {
  Triangles mesh;
  for (const Vec3& p : part.points)
    for (const double x : {p.x, p.y, p.z}) mesh.positions.push_back(static_cast<float>(x));
  for (const auto& triangle : part.triangles) mesh.indices.insert(mesh.indices.end(), triangle.begin(), triangle.end());
  return mesh;
}

}  // namespace momentree::io
