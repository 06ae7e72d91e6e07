#pragma once
// Coordinate of a joint with one DoF (rad, m).
#include <momentree/simulate/events/single_dof.hpp>

namespace momentree::quantities {

struct Position : SingleDof {
  std::string_view key() const override { return "position"; }
  const char* summary() const override { return "Coordinate of a joint with one DoF (rad or m)"; }
  Dimension dimension() const override { return turns ? dimension::angle : dimension::length; }
  double of(double position, double) const override { return position; }
  std::optional<double> rate(const World& world) const override {
    const auto state = present(world);
    return state ? std::optional(state->second) : std::nullopt;
  }
};

}  // namespace momentree::quantities
