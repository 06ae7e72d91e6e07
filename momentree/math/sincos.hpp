#pragma once
// Sine and cosine without branches: vectorises over many angles, and every CPU gives the same bits (unlike libm).
#include <bit>
#include <cmath>
#include <cstdint>

namespace momentree {

/// Largest |x| (rad) for which `sincos` is accurate; callers with many angles use libm beyond it.
inline constexpr double sincos_range = 1e6;

/// Error below 1 ulp for |x| <= sincos_range. Cody-Waite reduction in three parts (33 + 33 + 53 bits of pi/2, as in fdlibm),
/// minimax polynomials of degree 13 and 14 on [-pi/4, pi/4].
inline void sincos(double x, double& s, double& c) {
  constexpr double magic = 6755399441055744.0;  // 1.5*2^52: adding it rounds to an integer in the low bits
  const double t = x * 0.63661977236758134308 + magic;
  const auto n = std::bit_cast<std::int64_t>(t);
  const double k = t - magic;
  const double a = x - k * 1.57079632673412561417e+00;
  const double b = k * 6.07710050630396597660e-11;
  const double r1 = a - b;
  const double low = (a - r1) - b - k * 2.02226624879595063154e-21;
  const double r = r1 + low;
  const double e = (r1 - r) + low;  // r + e is the reduced angle
  const double z = r * r, z2 = z * z;
  // Terms in pairs (Estrin): as many operations as Horner's scheme with half the latency.
  const double ps = (-1.66666666666666324348e-01 + z * 8.33333333332248946124e-03) +
                    z2 * ((-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06) +
                          z2 * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10));
  const double pc = (4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) +
                    z2 * ((2.48015872894767294178e-05 + z * -2.75573143513906633035e-07) +
                          z2 * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11));
  const double h = 0.5 * z, u = 1.0 - h;
  const double sine = r + (r * z * ps + e * u);
  const double cosine = u + (z2 * pc + (((1.0 - u) - h) - r * e));
  const double ss = (n & 1) != 0 ? cosine : sine, cc = (n & 1) != 0 ? sine : cosine;
  s = std::bit_cast<double>(std::bit_cast<std::uint64_t>(ss) ^ ((static_cast<std::uint64_t>(n) & 2) << 62));
  c = std::bit_cast<double>(std::bit_cast<std::uint64_t>(cc) ^ ((static_cast<std::uint64_t>(n + 1) & 2) << 62));
}

/// Any other scalar: its own sin and cos, found by argument-dependent lookup.
template <class T>
void sincos(const T& x, T& s, T& c) {
  using std::cos;
  using std::sin;
  s = sin(x);
  c = cos(x);
}

/// n angles; the results are stored separately.
template <class T>
void sincos(int n, const T* x, T* s, T* c) {
  for (int i = 0; i < n; ++i) sincos(x[i], s[i], c[i]);
}

}  // namespace momentree
