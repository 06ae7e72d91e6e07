#pragma once
#include <algorithm>

#include <momentree/simulate/simulation.hpp>

namespace momentree::test {

/// The largest difference of the bodies' positions and velocities; NaN is kept.
inline double apart(const Simulation& one, const Simulation& other) {
  const auto a = one.world().motions(), b = other.world().motions();
  double most = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    for (const double off :
         {norm(a[k].pose.position - b[k].pose.position), norm(a[k].linear - b[k].linear), norm(a[k].angular - b[k].angular)})
      if (!(off <= most)) most = off;
  return most;
}

}  // namespace momentree::test
