#include <momentree/scenario/read/collider_shapes.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <momentree/contact/shapes/feature.hpp>
#include <momentree/contact/shapes/height_field.hpp>

namespace momentree::io {

namespace {

Quat from_axes(const Vec3& x, const Vec3& y, const Vec3& z) {
  return quaternion_of({x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z});
}

/// A placement with z from one point to another, in the middle.
Pose along_z(const Vec3& from, const Vec3& to) {
  const Vec3 z = normalized(to - from);
  Vec3 across[2];
  contact::perpendiculars(z, across);
  return {0.5 * (from + to), from_axes(across[0], across[1], z)};
}

// The faces of a hull.
MeshPart faces_of(const contact::Solid& solid) {
  MeshPart part;
  part.points = solid.vertices;
  for (const contact::Solid::Face& face : solid.faces)
    for (std::size_t k = 2; k < face.corners.size(); ++k)
      part.triangles.push_back({static_cast<std::uint32_t>(face.corners[0]), static_cast<std::uint32_t>(face.corners[k - 1]),
                                static_cast<std::uint32_t>(face.corners[k])});
  return part;
}

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

bool can_be_drawn(const Shape& shape) {
  const auto one = [](const Shape& each) {
    return each.kind != Shape::Kind::none && (each.kind != Shape::Kind::mesh || each.source != nullptr);
  };
  return one(shape) || std::any_of(shape.more.begin(), shape.more.end(), one);
}

}  // namespace

Shape solid_shape(const contact::Solid& solid) {
  const std::vector<Vec3>& points = solid.vertices;
  Shape shape;
  shape.radius = solid.radius;
  if (solid.is_ellipsoid()) {
    const auto& axes = solid.axes;
    shape.kind = Shape::Kind::ellipsoid, shape.radius = 0;
    shape.size = {norm(axes[0]), norm(axes[1]), norm(axes[2])};
    shape.at = {solid.centre, from_axes(normalized(axes[0]), normalized(axes[1]), normalized(axes[2]))};
  } else if (solid.rim > 0) {
    shape.kind = Shape::Kind::cylinder;
    shape.radius = solid.rim, shape.length = norm(solid.ends[1] - solid.ends[0]);
    shape.at = along_z(solid.ends[0], solid.ends[1]);
  } else if (points.size() == 1) {
    shape.kind = Shape::Kind::sphere;
    shape.at.position = points[0];
  } else if (points.size() == 2) {
    shape.kind = Shape::Kind::capsule;
    shape.length = norm(points[1] - points[0]);
    shape.at = along_z(points[0], points[1]);
  } else if (points.size() == 8 && solid.faces.size() == 6) {  // as contact::box makes them; hulls have triangles
    const Vec3 sides[] = {points[1] - points[0], points[2] - points[0], points[4] - points[0]};
    shape.kind = Shape::Kind::box;
    shape.size = {norm(sides[0]), norm(sides[1]), norm(sides[2])};
    shape.at = {0.5 * (points[0] + points[7]), from_axes(normalized(sides[0]), normalized(sides[1]), normalized(sides[2]))};
  }
  return shape;
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
    if (each.shape.kind == Shape::Kind::none) each.shape.kind = Shape::Kind::mesh, each.mesh = faces_of(collider.solid);
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
