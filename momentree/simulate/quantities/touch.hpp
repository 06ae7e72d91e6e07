#pragma once
// Whether two bodies touch: 1 or 0.
#include <momentree/simulate/events/of_contact.hpp>

namespace momentree::quantities {

struct Touch : OfContact {
  std::string_view key() const override { return "touch"; }
  const char* summary() const override { return "Two bodies touch; takes no threshold"; }
  Dimension dimension() const override { return dimension::number; }
  bool has_threshold() const override { return false; }
  bool is_impulsive() const override { return true; }  // the instant is that of an impact, which is located anyway
  std::optional<double> value(const World& world, std::span<const Event> now) const override {
    if (!exist(world)) return std::nullopt;
    if (begins(world, now)) return 1;
    bool touch = false;
    each_point(world, [&](const ContactPoint&, double) { touch = true; });
    if (touch) return 1;
    if (std::any_of(now.begin(), now.end(), [&](const Event& event) { return is_of(world, event); })) return 0;  // they part
    const std::optional<BodyGap> between = gap(world);
    return between && !between->passes && between->distance <= without_force ? 1 : 0;
  }
  bool begins(const World& world, std::span<const Event> now) const override {
    return std::any_of(now.begin(), now.end(),
                       [&](const Event& event) { return event.contact.impulse != Vec3{} && is_of(world, event); });
  }

 private:
  static constexpr double without_force = 1e-10;  // m: nearer bodies touch, even if nothing presses them together
};

}  // namespace momentree::quantities
