#pragma once
// Norm of the force between two bodies that touch (N).
#include <momentree/simulate/events/of_contact.hpp>

namespace momentree::quantities {

struct ContactForce : OfContact {
  std::string_view key() const override { return "contact_force"; }
  const char* summary() const override { return "Norm of the force between two bodies that touch; 0 if they do not (N)"; }
  Dimension dimension() const override { return dimension::force; }
  bool never_negative() const override { return true; }
  bool is_sum() const override { return true; }
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    if (!exist(world)) return std::nullopt;
    Vec3 sum{};
    each_point(world, [&](const ContactPoint& point, double sign) { sum += sign * point.force; });
    return norm(sum);
  }
};

}  // namespace momentree::quantities
