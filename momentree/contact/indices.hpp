#pragma once
#include <cmath>
#include <cstddef>
#include <type_traits>

namespace momentree::contact {

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

// A tenth of the time of std::hypot.
inline double length_of(double x, double y) { return std::sqrt(x * x + y * y); }

// Calls f with a number of degrees of freedom: for a free body with a constant, so that its loops are unrolled.
template <class F>
void sized(std::size_t count, F f) {
  if (count == 6)
    f(std::integral_constant<std::size_t, 6>{});
  else
    f(count);
}

// The same of several numbers at once: all are six, or none is a constant.
template <class F, class... Counts>
void all_sized(F f, Counts... counts) {
  if (((counts == 6) && ...))
    f((static_cast<void>(counts), std::integral_constant<std::size_t, 6>{})...);
  else
    f(counts...);
}

}  // namespace momentree::contact
