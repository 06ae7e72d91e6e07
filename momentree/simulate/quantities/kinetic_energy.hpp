#pragma once
// Kinetic energy of the bodies of a mechanism (J).
#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::quantities {

struct KineticEnergy : Quantity {
  std::string name;

  std::string_view key() const override { return "kinetic_energy"; }
  const char* summary() const override { return "Kinetic energy of a mechanism (J)"; }
  Dimension dimension() const override { return dimension::torque; }
  bool never_negative() const override { return true; }
  std::vector<std::string> mechanisms() const override { return {name}; }
  void arguments(const ArgumentVisitor& visit) override { visit({"mechanism", argument::Mechanism{name}}); }
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    double energy = 0;
    bool found = false, inside = false;
    for (const int b : world.tree().order()) {  // mechanism by mechanism, root first
      if (world.tree().parent(b) < 0) inside = world.mechanism_name({b}) == name;
      if (!inside) continue;
      found = true;
      const BodySpec& spec = world.model()[BodyId{b}];
      const BodyMotion& m = world.motions()[static_cast<std::size_t>(b)];
      const Mat3 R = rotation_matrix(m.pose.rotation);
      const Vec3 v = m.linear + cross(m.angular, R * spec.com), w = transpose_times(R, m.angular);
      energy += 0.5 * (spec.mass * dot(v, v) + dot(w, spec.inertia * w));
    }
    return found ? std::optional(energy) : std::nullopt;
  }
};

}  // namespace momentree::quantities
