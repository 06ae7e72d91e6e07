#pragma once
// Least distance of the solids of two bodies (m).
#include <momentree/simulate/of_contact.hpp>

namespace momentree::quantities {

struct Gap : OfContact {
  std::string_view key() const override { return "gap"; }
  const char* summary() const override { return "Least distance of two bodies, of what can touch (m)"; }
  Dimension dimension() const override { return dimension::length; }
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    const std::optional<BodyGap> gap = world.gap(number(world, one), number(world, other));
    return gap ? std::optional(gap->distance) : std::nullopt;
  }
  std::optional<double> rate(const World& world) const override {
    const std::optional<BodyGap> gap = world.gap(number(world, one), number(world, other));
    return gap ? std::optional(gap->rate) : std::nullopt;
  }
};

}  // namespace momentree::quantities
