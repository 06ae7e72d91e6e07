#pragma once
// Dormand–Prince 5(4) (1980): six evaluations per step, one error estimate; dense output of order 4 (Hairer, Nørsett, Wanner,
// Solving Ordinary Differential Equations I, II.5 and II.6).
#include <array>

#include <momentree/integrate/embedded.hpp>

namespace momentree {

struct DormandPrince5 {
  static constexpr int stages = 7, order = 5, lower = 4, estimates = 1;
  static constexpr double c[6] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1};
  static constexpr double a[6][6] = {{},
                                     {1.0 / 5},
                                     {3.0 / 40, 9.0 / 40},
                                     {44.0 / 45, -56.0 / 15, 32.0 / 9},
                                     {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                                     {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656}};
  static constexpr double b[6] = {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84};
  static constexpr double error[1][7] = {{71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40}};
  static double combine(const double* found) { return found[0]; }

  /// Weights of the stages at a fraction x of the step: cubic Hermite polynomial between the ends, plus a quartic that vanishes
  /// there with its slope.
  static std::array<double, 7> dense(double x) {
    constexpr double quartic[7] = {-12715105075.0 / 11282082432,  0,
                                   87487479700.0 / 32700410799,   -10690763975.0 / 1880347072,
                                   701980252875.0 / 199316789632, -1453857185.0 / 822651844,
                                   69997945.0 / 29380423};
    std::array<double, 7> w{};
    const double y = 1 - x, rise = x * x * (3 - 2 * x), bump = x * x * y * y;
    for (std::size_t j = 0; j < 7; ++j) w[j] = bump * quartic[j] + (j < 6 ? rise * b[j] : 0.0);
    w[0] += x * y * y;
    w[6] -= x * x * y;
    return w;
  }
};

class Dopri5 final : public Embedded<DormandPrince5> {
 public:
  using Embedded::Embedded;
};

}  // namespace momentree
