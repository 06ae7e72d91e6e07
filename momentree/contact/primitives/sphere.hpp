#pragma once
// A sphere.
#include <numbers>
#include <optional>

#include <momentree/contact/primitives/declaration.hpp>

namespace momentree::contact {

struct Sphere {
  static constexpr PrimitiveInfo info{"sphere", "spheres", "A sphere"};
  double radius = 1;
  friend bool operator==(const Sphere&, const Sphere&) = default;

  Solid solid(const Pose& at) const { return sphere(radius, at); }
  static std::optional<Placed<Sphere>> from(const Solid& solid) {
    if (solid.vertices.size() != 1 || solid.is_smooth()) return std::nullopt;
    return Placed<Sphere>{{solid.radius}, Pose(solid.vertices[0])};
  }
  UniformBody uniform() const {
    const double v = 4.0 / 3 * std::numbers::pi * radius * radius * radius, i = 0.4 * v * radius * radius;
    return {v, {i, i, i}};
  }
  StandardSolid standard() const { return {StandardSolid::Kind::ellipsoid, 2 * Vec3{radius, radius, radius}}; }
};
template <class Visitor, Like<Sphere> S>
void describe(Visitor& visit, S& sphere) {
  visit("radius", sphere.radius, Field{"its radius", dimension::length, Range::positive}.needed(""));
}

}  // namespace momentree::contact
