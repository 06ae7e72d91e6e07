#pragma once
// A capsule: a cylinder with a half sphere on each end.
#include <numbers>
#include <optional>

#include <momentree/contact/primitives/declaration.hpp>

namespace momentree::contact {

struct Capsule {
  static constexpr PrimitiveInfo info{"capsule", "capsules", "A capsule along z"};
  double radius = 1, length = 1;
  friend bool operator==(const Capsule&, const Capsule&) = default;

  Solid solid(const Pose& at) const { return capsule(radius, length, at); }
  static std::optional<Placed<Capsule>> from(const Solid& solid) {
    const std::vector<Vec3>& ends = solid.vertices;
    if (ends.size() != 2) return std::nullopt;
    return Placed<Capsule>{{solid.radius, norm(ends[1] - ends[0])}, placed_along_z(ends[0], ends[1])};
  }
  UniformBody uniform() const {
    const double pi = std::numbers::pi, r = radius, h = length, caps = 4.0 / 3 * pi * r * r * r, middle = pi * r * r * h;
    // Two hemispheres, each with 3/8 r from its base to its centre of mass, on a cylinder.
    const double across = middle * (3 * r * r + h * h) / 12 + caps * (0.4 * r * r + 0.375 * r * h + 0.25 * h * h);
    return {caps + middle, {across, across, middle * r * r / 2 + caps * 0.4 * r * r}};
  }
  StandardSolid standard() const { return {StandardSolid::Kind::capsule, {2 * radius, 2 * radius, length}}; }
};
template <class Visitor, Like<Capsule> C>
void describe(Visitor& visit, C& capsule) {
  const auto size = [](const char* about) { return Field{about, dimension::length, Range::positive}.needed(""); };
  visit("radius", capsule.radius, size("Radius"));
  visit("length", capsule.length, size("Distance between the centres of its caps"));
}

}  // namespace momentree::contact
