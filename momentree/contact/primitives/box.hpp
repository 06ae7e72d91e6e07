#pragma once
// A box.
#include <optional>

#include <momentree/contact/primitives/declaration.hpp>

namespace momentree::contact {

struct Box {
  static constexpr PrimitiveInfo info{"box", "boxes", "A box"};
  Vec3 size{1, 1, 1};
  friend bool operator==(const Box&, const Box&) = default;

  Solid solid(const Pose& at) const { return box(size, at); }
  static std::optional<Placed<Box>> from(const Solid& solid) {
    const std::vector<Vec3>& p = solid.vertices;
    // As contact::box makes them; hulls have triangles.
    if (p.size() != 8 || solid.faces.size() != 6 || solid.radius > 0) return std::nullopt;
    const Vec3 sides[] = {p[1] - p[0], p[2] - p[0], p[4] - p[0]};
    return Placed<Box>{
        {{norm(sides[0]), norm(sides[1]), norm(sides[2])}},
        {0.5 * (p[0] + p[7]), rotation_from_axes(normalized(sides[0]), normalized(sides[1]), normalized(sides[2]))}};
  }
  UniformBody uniform() const {
    const Vec3& s = size;
    const double v = s.x * s.y * s.z;
    return {v, {v * (s.y * s.y + s.z * s.z) / 12, v * (s.x * s.x + s.z * s.z) / 12, v * (s.x * s.x + s.y * s.y) / 12}};
  }
  StandardSolid standard() const { return {StandardSolid::Kind::box, size}; }
};
template <class Visitor, Like<Box> B>
void describe(Visitor& visit, B& box) {
  visit("size", box.size, Field{"its three edges", dimension::length, Range::positive}.needed(""));
}

}  // namespace momentree::contact
