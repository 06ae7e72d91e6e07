#pragma once
// Truncated series in one or two infinitesimals, over long double, and the vector algebra that forward kinematics needs.
// Independent of the engine.
#include <array>
#include <cmath>

namespace momentree::oracle {

using Real = long double;

/// r + e·ε with ε² = 0: a value and its derivative.
struct Dual {
  Real r = 0, e = 0;
  constexpr Dual() = default;
  constexpr Dual(Real real, Real epsilon = 0) : r(real), e(epsilon) {}  // NOLINT(google-explicit-constructor)
  static Dual variable(Real value, Real epsilon, Real, Real) { return {value, epsilon}; }
};
inline Dual operator+(const Dual& a, const Dual& b) { return {a.r + b.r, a.e + b.e}; }
inline Dual operator-(const Dual& a, const Dual& b) { return {a.r - b.r, a.e - b.e}; }
inline Dual operator*(const Dual& a, const Dual& b) { return {a.r * b.r, a.r * b.e + a.e * b.r}; }
inline Dual operator*(Real a, const Dual& b) { return {a * b.r, a * b.e}; }
inline Dual operator/(const Dual& a, const Dual& b) { return {a.r / b.r, (a.e - a.r / b.r * b.e) / b.r}; }
inline Dual sqrt(const Dual& a) {
  const Real s = std::sqrt(a.r);
  return {s, s == 0 ? 0 : a.e / (2 * s)};
}
inline Dual atan2(const Dual& y, const Dual& x) {
  return {std::atan2(y.r, x.r), (x.r * y.e - y.r * x.e) / (x.r * x.r + y.r * y.r)};
}
inline Dual sin(const Dual& a) { return {std::sin(a.r), std::cos(a.r) * a.e}; }
inline Dual cos(const Dual& a) { return {std::cos(a.r), -std::sin(a.r) * a.e}; }

/// r + e·ε + t·τ + et·ετ with ε² = τ² = 0: ε perturbs a coordinate, τ is time along the motion.
struct Jet {
  Real r = 0, e = 0, t = 0, et = 0;
  constexpr Jet() = default;
  constexpr Jet(Real real, Real epsilon = 0, Real tau = 0, Real both = 0)  // NOLINT(google-explicit-constructor)
      : r(real), e(epsilon), t(tau), et(both) {}
  static Jet variable(Real value, Real epsilon, Real tau, Real) { return {value, epsilon, tau, 0}; }
};
inline Jet operator+(const Jet& a, const Jet& b) { return {a.r + b.r, a.e + b.e, a.t + b.t, a.et + b.et}; }
inline Jet operator-(const Jet& a, const Jet& b) { return {a.r - b.r, a.e - b.e, a.t - b.t, a.et - b.et}; }
inline Jet operator*(const Jet& a, const Jet& b) {
  return {a.r * b.r, a.r * b.e + a.e * b.r, a.r * b.t + a.t * b.r, a.r * b.et + a.e * b.t + a.t * b.e + a.et * b.r};
}
inline Jet operator*(Real a, const Jet& b) { return {a * b.r, a * b.e, a * b.t, a * b.et}; }
inline Jet sin(const Jet& a) {
  const Real s = std::sin(a.r), c = std::cos(a.r);
  return {s, c * a.e, c * a.t, c * a.et - s * a.e * a.t};
}
inline Jet cos(const Jet& a) {
  const Real s = std::sin(a.r), c = std::cos(a.r);
  return {c, -s * a.e, -s * a.t, -s * a.et - c * a.e * a.t};
}

/// A time-dependent value with its first and second time derivative.
struct Curve {
  Real r = 0, t = 0, tt = 0;
  constexpr Curve() = default;
  constexpr Curve(Real real, Real first = 0, Real second = 0)  // NOLINT(google-explicit-constructor)
      : r(real), t(first), tt(second) {}
  static Curve variable(Real value, Real, Real first, Real second) { return {value, first, second}; }
};
inline Curve operator+(const Curve& a, const Curve& b) { return {a.r + b.r, a.t + b.t, a.tt + b.tt}; }
inline Curve operator-(const Curve& a, const Curve& b) { return {a.r - b.r, a.t - b.t, a.tt - b.tt}; }
inline Curve operator*(const Curve& a, const Curve& b) {
  return {a.r * b.r, a.r * b.t + a.t * b.r, a.r * b.tt + 2 * a.t * b.t + a.tt * b.r};
}
inline Curve operator*(Real a, const Curve& b) { return {a * b.r, a * b.t, a * b.tt}; }
inline Curve sin(const Curve& a) {
  const Real s = std::sin(a.r), c = std::cos(a.r);
  return {s, c * a.t, c * a.tt - s * a.t * a.t};
}
inline Curve cos(const Curve& a) {
  const Real s = std::sin(a.r), c = std::cos(a.r);
  return {c, -s * a.t, -s * a.tt - c * a.t * a.t};
}

template <class T>
struct V3 : std::array<T, 3> {};
/// Row-major.
template <class T>
struct M3 : std::array<T, 9> {};

template <class T>
V3<T> operator+(const V3<T>& a, const V3<T>& b) {
  return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
}
template <class T>
V3<T> operator-(const V3<T>& a, const V3<T>& b) {
  return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}};
}
template <class T>
V3<T> scaled(const T& s, const V3<T>& a) {
  return {{s * a[0], s * a[1], s * a[2]}};
}
inline Real dot(const V3<Real>& a, const V3<Real>& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline V3<Real> cross(const V3<Real>& a, const V3<Real>& b) {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}
/// S is T, or Real if the factor is constant.
template <class T, class S>
V3<T> operator*(const M3<T>& m, const V3<S>& a) {
  V3<T> out;
  for (unsigned i = 0; i < 3; ++i) out[i] = a[0] * m[3 * i] + a[1] * m[3 * i + 1] + a[2] * m[3 * i + 2];
  return out;
}
template <class T, class S>
M3<T> operator*(const M3<T>& a, const M3<S>& b) {
  M3<T> out;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j) out[3 * i + j] = b[j] * a[3 * i] + b[3 + j] * a[3 * i + 1] + b[6 + j] * a[3 * i + 2];
  return out;
}
template <class T>
M3<T> transposed(const M3<T>& m) {
  return {{m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]}};
}
template <class T>
M3<T> skew(const V3<T>& a) {
  return {{T(0), T(0) - a[2], a[1], a[2], T(0), T(0) - a[0], T(0) - a[1], a[0], T(0)}};
}
/// Axial part of a matrix that is skew-symmetric to within round-off.
inline V3<Real> axial(const M3<Real>& m) { return {{(m[7] - m[5]) / 2, (m[2] - m[6]) / 2, (m[3] - m[1]) / 2}}; }

/// Pose of a frame: x_outer = position + rotation·x_inner.
template <class T>
struct Frame {
  M3<T> rotation{{T(1), T(0), T(0), T(0), T(1), T(0), T(0), T(0), T(1)}};
  V3<T> position{};
};
template <class T, class S>
Frame<T> operator*(const Frame<T>& a, const Frame<S>& b) {
  return {a.rotation * b.rotation, a.position + a.rotation * b.position};
}

}  // namespace momentree::oracle
