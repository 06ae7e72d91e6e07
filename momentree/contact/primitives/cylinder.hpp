#pragma once
// A cylinder.
#include <numbers>
#include <optional>

#include <momentree/contact/primitives/declaration.hpp>

namespace momentree::contact {

struct Cylinder {
  static constexpr PrimitiveInfo info{"cylinder", "cylinders", "A cylinder along z"};
  double radius = 1, length = 1;
  friend bool operator==(const Cylinder&, const Cylinder&) = default;

  Solid solid(const Pose& at) const { return cylinder(radius, length, at); }
  static std::optional<Placed<Cylinder>> from(const Solid& solid) {
    if (!(solid.rim > 0)) return std::nullopt;
    return Placed<Cylinder>{{solid.rim, norm(solid.ends[1] - solid.ends[0])}, placed_along_z(solid.ends[0], solid.ends[1])};
  }
  UniformBody uniform() const {
    const double r = radius, h = length, v = std::numbers::pi * r * r * h, across = v * (3 * r * r + h * h) / 12;
    return {v, {across, across, v * r * r / 2}};
  }
  StandardSolid standard() const { return {StandardSolid::Kind::cylinder, {2 * radius, 2 * radius, length}}; }
};
template <class Visitor, Like<Cylinder> C>
void describe(Visitor& visit, C& cylinder) {
  const auto size = [](const char* about) { return Field{about, dimension::length, Range::positive}.needed(""); };
  visit("radius", cylinder.radius, size("Radius"));
  visit("length", cylinder.length, size("Height"));
}

}  // namespace momentree::contact
