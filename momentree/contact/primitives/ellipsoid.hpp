#pragma once
// An ellipsoid.
#include <numbers>
#include <optional>

#include <momentree/contact/primitives/declaration.hpp>

namespace momentree::contact {

struct Ellipsoid {
  static constexpr PrimitiveInfo info{"ellipsoid", "ellipsoids", "An ellipsoid"};
  Vec3 semi_axes{1, 1, 1};
  friend bool operator==(const Ellipsoid&, const Ellipsoid&) = default;

  Solid solid(const Pose& at) const { return ellipsoid(semi_axes, at); }
  static std::optional<Placed<Ellipsoid>> from(const Solid& solid) {
    if (!solid.is_smooth()) return std::nullopt;
    const auto& [x, y, z] = solid.axes;
    return Placed<Ellipsoid>{{{norm(x), norm(y), norm(z)}},
                             {solid.centre, rotation_from_axes(normalized(x), normalized(y), normalized(z))}};
  }
  UniformBody uniform() const {
    const Vec3& s = semi_axes;
    const double v = 4.0 / 3 * std::numbers::pi * s.x * s.y * s.z;
    return {v, {v * (s.y * s.y + s.z * s.z) / 5, v * (s.x * s.x + s.z * s.z) / 5, v * (s.x * s.x + s.y * s.y) / 5}};
  }
  StandardSolid standard() const { return {StandardSolid::Kind::ellipsoid, 2 * semi_axes}; }
};
template <class Visitor, Like<Ellipsoid> E>
void describe(Visitor& visit, E& ellipsoid) {
  visit("size", ellipsoid.semi_axes, Field{"its three semi-axes", dimension::length, Range::positive}.needed(""));
}

}  // namespace momentree::contact
