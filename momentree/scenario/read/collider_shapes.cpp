#include <momentree/scenario/read/collider_shapes.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <momentree/contact/shapes/height_field.hpp>

namespace momentree::io {

namespace {

// Of a large field, some of its rows and columns.
MeshPart surface_of(const contact::HeightField& field) {
  static constexpr int most = 100;
  const auto chosen = [](int count) {
    std::vector<int> all;
    const int lines = std::min(count, most);
    for (int k = 0; k < lines; ++k) all.push_back(static_cast<int>(static_cast<long>(k) * (count - 1) / (lines - 1)));
    return all;
  };
  const std::vector<int> columns = chosen(field.columns), rows = chosen(field.rows);
  MeshPart part;
  for (const int j : rows)
    for (const int i : columns)
      part.points.push_back(
          {field.x * (i / (field.columns - 1.0) - 0.5), field.y * (j / (field.rows - 1.0) - 0.5),
           field.heights[static_cast<std::size_t>(j) * static_cast<std::size_t>(field.columns) + static_cast<std::size_t>(i)]});
  const auto across = static_cast<std::uint32_t>(columns.size());
  for (std::uint32_t j = 0; j + 1 < rows.size(); ++j)
    for (std::uint32_t i = 0; i + 1 < across; ++i) {
      const std::uint32_t a = across * j + i, b = a + 1, c = a + across, d = c + 1;
      part.triangles.push_back({a, b, c}), part.triangles.push_back({d, c, b});
    }
  return part;
}

// Points of a rounded polyhedron, or of a smooth solid, that are farthest along some directions.
std::vector<Vec3> farthest_points(const contact::Solid& solid) {
  const contact::SmoothSurface* const surface = contact::smooth_surface(solid.surface);
  std::vector<Vec3> points;
  for (const Vec3& n : contact::directions(16)) {
    if (surface != nullptr) {
      points.push_back(solid.centre + surface->farthest(solid.axes, n));
      continue;
    }
    double farthest = -HUGE_VAL;
    for (const Vec3& v : solid.vertices) farthest = std::max(farthest, dot(n, v));
    for (const Vec3& v : solid.vertices)
      if (dot(n, v) >= farthest - 1e-9 * solid.reach) points.push_back(v + solid.radius * n);
  }
  return points;
}

bool can_be_drawn(const Shape& shape) {
  const auto one = [](const Shape& each) {
    return each.kind != Shape::Kind::none && (each.kind != Shape::Kind::mesh || each.source != nullptr);
  };
  return one(shape) || std::any_of(shape.more.begin(), shape.more.end(), one);
}

}  // namespace

Shape solid_shape(const contact::Solid& solid) {
  const auto placed = contact::primitive_of(solid);
  return placed ? Shape::of(placed->shape, placed->at) : Shape{};
}

MeshPart surface_of(const contact::Solid& solid) {
  if (solid.radius > 0) return surface_of(contact::hull(farthest_points(solid)));
  MeshPart part;
  part.points = solid.vertices;
  for (const contact::Solid::Face& face : solid.faces)
    for (std::size_t k = 2; k < face.corners.size(); ++k)
      part.triangles.push_back({static_cast<std::uint32_t>(face.corners[0]), static_cast<std::uint32_t>(face.corners[k - 1]),
                                static_cast<std::uint32_t>(face.corners[k])});
  return part;
}

std::vector<GroundShape> ground_shapes(const Model& model) {
  std::vector<GroundShape> all;
  for (const Collider& collider : model.colliders()) {
    if (collider.plane || collider.body != ground) continue;
    GroundShape& each = all.emplace_back();
    if (collider.field) {
      each = {{.kind = Shape::Kind::mesh, .at = collider.field->at}, surface_of(*collider.field)};
      continue;
    }
    each.shape = solid_shape(collider.solid);
    if (each.shape.kind == Shape::Kind::none) each.shape.kind = Shape::Kind::mesh, each.mesh = surface_of(collider.solid);
  }
  return all;
}

std::vector<Shape> drawn_shapes(const Model& model, const std::vector<Shape>& shapes) {
  std::vector<Shape> drawn = shapes, touching(static_cast<std::size_t>(model.size()));
  drawn.resize(touching.size());
  for (const Collider& collider : model.colliders()) {
    if (collider.plane || collider.body == ground) continue;
    const auto b = static_cast<std::size_t>(collider.body.index);
    Shape shape = can_be_drawn(drawn[b]) ? Shape{} : solid_shape(collider.solid);
    if (shape.kind == Shape::Kind::none) continue;
    if (touching[b].kind == Shape::Kind::none)
      touching[b] = std::move(shape);
    else
      touching[b].more.push_back(std::move(shape));
  }
  for (std::size_t b = 0; b < touching.size(); ++b)
    if (touching[b].kind != Shape::Kind::none) drawn[b] = std::move(touching[b]);
  return drawn;
}

}  // namespace momentree::io
