#pragma once
// Sine and cosine of single angles with the same bits from every compiler and C library.
#include <cmath>

#include <momentree/math/sincos.hpp>

namespace momentree {

struct SineCosine {
  double s, c;
};
/// Angles beyond sincos_range use the C library.
inline SineCosine sine_cosine(double angle) {
  SineCosine both{};
  if (!(std::fabs(angle) <= sincos_range)) return {std::sin(angle), std::cos(angle)};
  sincos(angle, both.s, both.c);
  return both;
}

}  // namespace momentree
