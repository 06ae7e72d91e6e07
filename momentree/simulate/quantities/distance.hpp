#pragma once
// Distance between two points of bodies.
#include <momentree/simulate/condition.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree::quantities {

struct Distance : Quantity {
  std::string one, other;
  Vec3 point_of_one{}, point_of_other{};

  std::string_view key() const override { return "distance"; }
  Dimension dimension() const override { return dimension::length; }
  bool never_negative() const override { return true; }
  void fields(QuantityFields& fields) override {
    fields.point(0, 2, one, point_of_one);
    fields.point(1, 2, other, point_of_other);
  }
  std::vector<std::string> bodies() const override { return {one, other}; }
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    const auto place = [&world](const std::string& name, const Vec3& point) -> std::optional<Vec3> {
      if (name == "ground") return point;
      const Body body = world.model().body(name);
      if (!world.alive(body)) return std::nullopt;
      return world.motions()[static_cast<std::size_t>(body.index)].pose * point;
    };
    const auto a = place(one, point_of_one), b = place(other, point_of_other);
    return a && b ? std::optional(norm(*a - *b)) : std::nullopt;
  }
};

}  // namespace momentree::quantities
