#pragma once
// Distance between two points of bodies (m).
#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::quantities {

struct Distance : Quantity {
  std::string one, other;
  Vec3 point_of_one{}, point_of_other{};

  std::string_view key() const override { return "distance"; }
  const char* summary() const override {
    return "Distance between two bodies: between the origins of their frames, or between points of them (m)";
  }
  Dimension dimension() const override { return dimension::length; }
  bool never_negative() const override { return true; }
  void arguments(const ArgumentVisitor& visit) override {
    visit({"points", argument::TwoPoints{{one, point_of_one}, {other, point_of_other}}});
  }
  std::vector<std::string> bodies() const override { return {one, other}; }
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    const auto a = end(world, one, point_of_one), b = end(world, other, point_of_other);
    return a && b ? std::optional(norm(a->place - b->place)) : std::nullopt;
  }
  std::optional<double> rate(const World& world) const override {
    const auto a = end(world, one, point_of_one), b = end(world, other, point_of_other);
    if (!a || !b) return std::nullopt;
    const Vec3 apart = a->place - b->place;
    const double distance = norm(apart);
    return distance > 0 ? std::optional(dot(apart, a->velocity - b->velocity) / distance) : std::nullopt;
  }

 private:
  struct End {
    Vec3 place, velocity;
  };
  static std::optional<End> end(const World& world, const std::string& name, const Vec3& point) {
    if (name == "ground") return End{point, {}};
    const BodyId body = world.model().body(name);
    if (!world.alive(body)) return std::nullopt;
    const BodyMotion& motion = world.motions()[static_cast<std::size_t>(body.index)];
    return End{motion.pose * point, velocity_of(motion, point)};
  }
};

}  // namespace momentree::quantities
