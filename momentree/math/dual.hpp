#pragma once
// A value with its derivatives: functions of it carry both. For force laws and the geometry of single joints; derivatives of
// whole recursions are cheaper by their own tangents (dynamics/tangent/acceleration_tangent.hpp).
#include <cmath>

#include <momentree/base/inline.hpp>

namespace momentree {

/// r + e·ε with ε² = 0. E: a double, or a Pack for as many directions at once.
template <class E>
struct Dual {
  double r = 0;
  E e{};

  Dual() = default;
  MOMENTREE_INLINE explicit Dual(double value) : r(value), e(0.0) {}
  MOMENTREE_INLINE Dual(double value, const E& rate) : r(value), e(rate) {}

  MOMENTREE_INLINE friend Dual operator+(const Dual& a, const Dual& b) { return {a.r + b.r, a.e + b.e}; }
  MOMENTREE_INLINE friend Dual operator-(const Dual& a, const Dual& b) { return {a.r - b.r, a.e - b.e}; }
  MOMENTREE_INLINE friend Dual operator*(const Dual& a, const Dual& b) { return {a.r * b.r, a.r * b.e + b.r * a.e}; }
  MOMENTREE_INLINE friend Dual operator/(const Dual& a, const Dual& b) {
    const double ratio = a.r / b.r;
    return {ratio, (a.e - ratio * b.e) * (1 / b.r)};
  }
  MOMENTREE_INLINE friend Dual operator-(const Dual& a) { return {-a.r, -a.e}; }
  MOMENTREE_INLINE friend Dual operator+(const Dual& a, double b) { return {a.r + b, a.e}; }
  MOMENTREE_INLINE friend Dual operator+(double a, const Dual& b) { return {a + b.r, b.e}; }
  MOMENTREE_INLINE friend Dual operator-(const Dual& a, double b) { return {a.r - b, a.e}; }
  MOMENTREE_INLINE friend Dual operator-(double a, const Dual& b) { return {a - b.r, -b.e}; }
  MOMENTREE_INLINE friend Dual operator*(const Dual& a, double b) { return {a.r * b, b * a.e}; }
  MOMENTREE_INLINE friend Dual operator*(double a, const Dual& b) { return {a * b.r, a * b.e}; }
  MOMENTREE_INLINE friend Dual operator/(const Dual& a, double b) { return a * (1 / b); }
  MOMENTREE_INLINE friend Dual operator/(double a, const Dual& b) { return Dual(a) / b; }
  template <class B>
  MOMENTREE_INLINE friend Dual& operator+=(Dual& a, const B& b) {
    return a = a + b;
  }
  template <class B>
  MOMENTREE_INLINE friend Dual& operator-=(Dual& a, const B& b) {
    return a = a - b;
  }

  /// Zero at zero, as for the norm of a vector there.
  MOMENTREE_INLINE friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.r);
    return {root, (root > 0 ? 0.5 / root : 0.0) * a.e};
  }
  MOMENTREE_INLINE friend Dual tan(const Dual& a) {
    const double t = std::tan(a.r);
    return {t, (1 + t * t) * a.e};
  }
  MOMENTREE_INLINE friend Dual atan2(const Dual& y, const Dual& x) {
    return {std::atan2(y.r, x.r), (x.r * y.e - y.r * x.e) * (1 / (x.r * x.r + y.r * y.r))};
  }
};

/// The value of a number that may be a Dual: what branches depend on.
MOMENTREE_INLINE constexpr double value_of(double a) { return a; }
template <class E>
MOMENTREE_INLINE double value_of(const Dual<E>& a) {
  return a.r;
}

}  // namespace momentree
