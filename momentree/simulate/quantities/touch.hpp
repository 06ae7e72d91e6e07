#pragma once
// Whether two bodies touch: 1 or 0.
#include <momentree/simulate/of_contact.hpp>

namespace momentree::quantities {

struct Touch : OfContact {
  std::string_view key() const override { return "touch"; }
  const char* summary() const override { return "Two bodies touch; takes no threshold"; }
  Dimension dimension() const override { return dimension::number; }
  bool has_threshold() const override { return false; }
  bool is_impulsive() const override { return true; }  // the instant is that of an impact, which is located anyway
  std::optional<double> value(const World& world, std::span<const Event> now) const override {
    if (!exist(world)) return std::nullopt;
    bool touch = std::any_of(now.begin(), now.end(), [&](const Event& event) { return is_of(event); });
    each_point(world, [&](const ContactPoint&, double) { touch = true; });
    return touch ? 1 : 0;
  }
};

}  // namespace momentree::quantities
