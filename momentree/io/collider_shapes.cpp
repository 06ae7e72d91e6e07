#include <momentree/io/collider_shapes.hpp>

#include <cmath>
#include <utility>

namespace momentree::io {
namespace {

Quat from_axes(const Vec3& x, const Vec3& y, const Vec3& z) {
  return quaternion_of({x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z});
}

/// The shape of a solid; none for a hull that is not a box.
Shape solid_shape(const contact::Solid& solid) {
  const std::vector<Vec3>& points = solid.vertices;
  Shape shape;
  shape.radius = solid.radius;
  if (points.size() == 1) {
    shape.kind = Shape::Kind::sphere;
    shape.at.position = points[0];
  } else if (points.size() == 2) {
    const Vec3 along = points[1] - points[0];
    shape.kind = Shape::Kind::capsule;
    shape.length = norm(along);
    const Vec3 z = (1 / shape.length) * along;
    Vec3 x = cross(z, std::abs(z.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0});
    x = (1 / norm(x)) * x;
    const Vec3 y = cross(z, x);
    shape.at = {0.5 * (points[0] + points[1]), from_axes(x, y, z)};
  } else if (points.size() == 8 && solid.faces.size() == 6) {  // as contact::box makes them
    const Vec3 sides[] = {points[1] - points[0], points[2] - points[0], points[4] - points[0]};
    shape.kind = Shape::Kind::box;
    shape.size = {norm(sides[0]), norm(sides[1]), norm(sides[2])};
    shape.at = {0.5 * (points[0] + points[7]),
                from_axes((1 / shape.size.x) * sides[0], (1 / shape.size.y) * sides[1], (1 / shape.size.z) * sides[2])};
  }
  return shape;
}

}  // namespace

std::vector<Shape> drawn_shapes(const Model& model, const std::vector<Shape>& shapes) {
  std::vector<Shape> drawn = shapes;
  drawn.resize(static_cast<std::size_t>(model.size()));
  std::vector<bool> own;
  for (const Shape& shape : drawn) own.push_back(shape.kind != Shape::Kind::none);
  for (const Collider& collider : model.colliders()) {
    if (collider.plane || collider.body == ground) continue;
    const auto b = static_cast<std::size_t>(collider.body.index);
    Shape shape = own[b] ? Shape{} : solid_shape(collider.solid);
    if (shape.kind == Shape::Kind::none) continue;
    if (drawn[b].kind == Shape::Kind::none)
      drawn[b] = std::move(shape);
    else
      drawn[b].more.push_back(std::move(shape));
  }
  return drawn;
}

}  // namespace momentree::io
