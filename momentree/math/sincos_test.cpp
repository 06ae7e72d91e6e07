#include <momentree/math/sincos.hpp>

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

using namespace momentree;

namespace {
double ulps(double got, long double want) {
  const double w = static_cast<double>(want);
  const double unit = std::nextafter(std::fabs(w), HUGE_VAL) - std::fabs(w);
  return static_cast<double>(std::fabs(static_cast<long double>(got) - want) / static_cast<long double>(unit));
}
}  // namespace

TEST_CASE("sincos is right to an ulp over its range, also near multiples of pi/2") {
  double worst = 0;
  const auto check = [&](double x) {
    double s = 0, c = 0;
    sincos(x, s, c);
    worst = std::fmax(worst, ulps(s, std::sin(static_cast<long double>(x))));
    worst = std::fmax(worst, ulps(c, std::cos(static_cast<long double>(x))));
  };
  unsigned long long state = 88172645463325252ULL;
  for (int i = 0; i < 200000; ++i) {
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    const double u = static_cast<double>(state >> 11) * (2.0 / 9007199254740992.0) - 1;
    check(3.2 * u);
    check(100 * u);
    check(sincos_range * u);
    check(u * 1e-6);
  }
  CHECK(worst < 1.0);
  for (int k = -1000; k <= 1000; ++k) {  // the result that is nearly zero is right in its absolute error
    const double x = k * 1.5707963267948966;
    double s = 0, c = 0;
    sincos(x, s, c);
    CHECK(std::fabs(static_cast<long double>(s) - std::sin(static_cast<long double>(x))) < 2e-16L);
    CHECK(std::fabs(static_cast<long double>(c) - std::cos(static_cast<long double>(x))) < 2e-16L);
  }
}

TEST_CASE("sincos of a batch with an angle beyond its range, and of what is not a number") {
  const double x[3] = {0.5, 1e9, -2};
  double s[3], c[3];
  sincos(3, x, s, c);
  CHECK(s[1] == doctest::Approx(std::sin(1e9)));
  CHECK(c[2] == doctest::Approx(std::cos(-2.0)));
  const double bad[1] = {std::numeric_limits<double>::quiet_NaN()};
  sincos(1, bad, s, c);
  CHECK(std::isnan(s[0]));
  const double wide[1] = {std::numeric_limits<double>::infinity()};
  sincos(1, wide, s, c);
  CHECK(std::isnan(c[0]));
}
