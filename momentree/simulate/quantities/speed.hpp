#pragma once
// Velocity of a joint with one DoF (rad/s, m/s).
#include <momentree/simulate/events/single_dof.hpp>

namespace momentree::quantities {

struct Speed : SingleDof {
  std::string_view key() const override { return "speed"; }
  const char* summary() const override { return "Velocity of a joint with one DoF (rad/s or m/s)"; }
  Dimension dimension() const override { return turns ? dimension::angular_speed : dimension::speed; }
  double of(double, double speed) const override { return speed; }
};

}  // namespace momentree::quantities
