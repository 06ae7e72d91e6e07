#pragma once
// Coordinate of a joint with one freedom.
#include <momentree/simulate/one_freedom.hpp>

namespace momentree::quantities {

struct Position : OneFreedom {
  std::string_view key() const override { return "position"; }
  Dimension dimension() const override { return turns ? dimension::angle : dimension::length; }
  double of(double position, double) const override { return position; }
};

}  // namespace momentree::quantities
