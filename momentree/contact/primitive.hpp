#pragma once
// Primitive shapes, of which each has a file in primitives/. Documents list them in this order.
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include <momentree/contact/primitives/box.hpp>
#include <momentree/contact/primitives/capsule.hpp>
#include <momentree/contact/primitives/cylinder.hpp>
#include <momentree/contact/primitives/ellipsoid.hpp>
#include <momentree/contact/primitives/sphere.hpp>

namespace momentree::contact {

using Primitive = std::variant<Box, Sphere, Cylinder, Capsule, Ellipsoid>;

/// Calls a function with one of each type.
template <class Function>
constexpr void each_primitive(const Function& call) {
  const auto all = [&call]<std::size_t... I>(std::index_sequence<I...>) {
    (call(std::variant_alternative_t<I, Primitive>{}), ...);
  };
  all(std::make_index_sequence<std::variant_size_v<Primitive>>());
}

inline const PrimitiveInfo& info(const Primitive& primitive) {
  return std::visit([](const auto& shape) -> const PrimitiveInfo& { return shape.info; }, primitive);
}
template <class Visitor, Like<Primitive> P>
void describe(Visitor& visit, P& primitive) {
  std::visit([&visit](auto& shape) { describe(visit, shape); }, primitive);
}

/// It has a support function of its own.
template <class Shape>
inline constexpr bool is_smooth = requires {
  &Shape::farthest;
};

inline Solid solid(const Primitive& primitive, const Pose& at) {
  return std::visit(
      [&]<class Shape>(const Shape& shape) {
        Solid made = shape.solid(at);
        if constexpr (is_smooth<Shape>) made.surface = static_cast<unsigned char>(primitive.index() + 1);
        return made;
      },
      primitive);
}
/// Nothing for the hull of points.
inline std::optional<Placed<Primitive>> primitive_of(const Solid& solid) {
  std::optional<Placed<Primitive>> found;
  unsigned char number = 0;
  each_primitive([&]<class Shape>(const Shape&) {
    ++number;
    if (found || solid.surface != (is_smooth<Shape> ? number : 0)) return;
    if (const auto placed = Shape::from(solid)) found = Placed<Primitive>{placed->shape, placed->at};
  });
  return found;
}

inline UniformBody uniform(const Primitive& primitive) {
  return std::visit([](const auto& shape) { return shape.uniform(); }, primitive);
}
inline std::optional<StandardSolid> standard(const Primitive& primitive) {
  return std::visit(
      [](const auto& shape) -> std::optional<StandardSolid> {
        if constexpr (requires { shape.standard(); }) return shape.standard();
        return std::nullopt;
      },
      primitive);
}

/// All of its sizes are greater than 0.
inline bool has_volume(const Primitive& primitive) {
  struct {
    bool all = true;
    void operator()(const char*, double x, const Field& field) { all = all && (field.range != Range::positive || x > 0); }
    void operator()(const char* key, const Vec3& v, const Field& field) {
      (*this)(key, v.x, field), (*this)(key, v.y, field), (*this)(key, v.z, field);
    }
  } sizes;
  describe(sizes, primitive);
  return sizes.all;
}

}  // namespace momentree::contact
