#pragma once
// Norm of the impulse of two bodies that hit each other (N s).
#include <momentree/simulate/events/of_contact.hpp>

namespace momentree::quantities {

struct ContactImpulse : OfContact {
  std::string_view key() const override { return "contact_impulse"; }
  const char* summary() const override { return "Norm of the impulse of two bodies that hit each other (N s)"; }
  Dimension dimension() const override { return dimension::force * dimension::time; }
  bool never_negative() const override { return true; }
  bool is_impulsive() const override { return true; }
  bool is_sum() const override { return true; }
  std::optional<double> value(const World& world, std::span<const Event> now) const override {
    Vec3 sum{};
    for (const Event& event : now) sum += sign_of(world, event) * event.contact.impulse;
    return norm(sum);
  }
};

}  // namespace momentree::quantities
