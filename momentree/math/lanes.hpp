#pragma once
// The lanes of a scalar, for what is computed in double, lane by lane: a pack has several, a double one.
#include <cstddef>

#include <momentree/base/inline.hpp>

namespace momentree {

template <class T>
inline constexpr int lanes_of = T::lanes;
template <>
inline constexpr int lanes_of<double> = 1;

MOMENTREE_INLINE double get_lane(const double& x, int) { return x; }
MOMENTREE_INLINE void set_lane(double& x, int, double value) { x = value; }
template <class T>
MOMENTREE_INLINE double get_lane(const T& x, int lane) {
  return x[lane];
}
template <class T>
MOMENTREE_INLINE void set_lane(T& x, int lane, double value) {
  x.set(lane, value);
}

/// One lane of a struct of scalars `Of<T>`, and the reverse. `Of` has no other members.
template <template <class> class Of, class T>
MOMENTREE_INLINE Of<double> lane_of(const Of<T>& all, int lane) {
  static_assert(sizeof(Of<T>) / sizeof(T) == sizeof(Of<double>) / sizeof(double));
  Of<double> one;
  for (std::size_t i = 0; i < sizeof(Of<T>) / sizeof(T); ++i)
    reinterpret_cast<double*>(&one)[i] = get_lane(reinterpret_cast<const T*>(&all)[i], lane);
  return one;
}
template <template <class> class Of, class T>
MOMENTREE_INLINE void set_lane_of(Of<T>& all, int lane, const Of<double>& one) {
  static_assert(sizeof(Of<T>) / sizeof(T) == sizeof(Of<double>) / sizeof(double));
  for (std::size_t i = 0; i < sizeof(Of<T>) / sizeof(T); ++i)
    set_lane(reinterpret_cast<T*>(&all)[i], lane, reinterpret_cast<const double*>(&one)[i]);
}

}  // namespace momentree
