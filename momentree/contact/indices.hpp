#pragma once
#include <cstddef>
#include <type_traits>

namespace momentree::contact {

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Calls f with a number of degrees of freedom: for a free body with a constant, so that its loops are unrolled.
template <class F>
void sized(std::size_t count, F f) {
  if (count == 6)
    f(std::integral_constant<std::size_t, 6>{});
  else
    f(count);
}

}  // namespace momentree::contact
