#pragma once
// Least distance of the solids of two bodies, or of those of mechanisms (m).
#include <momentree/simulate/events/of_contact.hpp>

namespace momentree::quantities {

struct Gap : OfContact {
  std::string_view key() const override { return "gap"; }
  const char* summary() const override { return "Least distance of two bodies, of what can touch (m)"; }
  Dimension dimension() const override { return dimension::length; }
  bool needs_contact() const override { return false; }
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    const std::optional<BodyGap> least = gap(world);
    return least ? std::optional(least->distance) : std::nullopt;
  }
  std::optional<double> rate(const World& world) const override {
    const std::optional<BodyGap> least = gap(world);
    return least ? std::optional(least->rate) : std::nullopt;
  }
};

}  // namespace momentree::quantities
