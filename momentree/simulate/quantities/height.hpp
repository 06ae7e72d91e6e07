#pragma once
// Height of a point of a body, against gravity (m).
#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::quantities {

struct Height : Quantity {
  std::string name;
  Vec3 point{};

  std::string_view key() const override { return "height"; }
  const char* summary() const override { return "Height of a body, or of a point of it, against gravity (m)"; }
  Dimension dimension() const override { return dimension::length; }
  void arguments(const ArgumentVisitor& visit) override { visit({"point", argument::Point{name, point}}); }
  std::vector<std::string> bodies() const override { return {name}; }
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    const BodyId body = world.model().body(name);
    if (!world.alive(body)) return std::nullopt;
    return dot(up(world), world.motions()[static_cast<std::size_t>(body.index)].pose * point);
  }
  std::optional<double> rate(const World& world) const override {
    const BodyId body = world.model().body(name);
    if (!world.alive(body)) return std::nullopt;
    return dot(up(world), velocity_of(world.motions()[static_cast<std::size_t>(body.index)], point));
  }

 private:
  static Vec3 up(const World& world) {
    const Vec3 g = world.model().gravity();
    const double size = norm(g);
    return size == 0 ? z_axis : (-1 / size) * g;
  }
};

}  // namespace momentree::quantities
