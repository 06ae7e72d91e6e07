#include <momentree/math/pack.hpp>

#include <cmath>
#include <limits>
#include <vector>

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
  for (int k = -1000; k <= 1000; ++k) {  // a result near zero is accurate to an absolute error
    const double x = k * 1.5707963267948966;
    double s = 0, c = 0;
    sincos(x, s, c);
    CHECK(std::fabs(static_cast<long double>(s) - std::sin(static_cast<long double>(x))) < 2e-16L);
    CHECK(std::fabs(static_cast<long double>(c) - std::cos(static_cast<long double>(x))) < 2e-16L);
  }
}

TEST_CASE("angles in groups of four give the same bits as one by one, with large angles and NaN among them") {
  std::vector<double> x(150);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = 0.37 * static_cast<double>(i) - 20;
  x[5] = 1e9, x[66] = std::numeric_limits<double>::quiet_NaN(), x[148] = std::numeric_limits<double>::infinity();
  for (int n = 0; n <= static_cast<int>(x.size()); ++n) {
    std::vector<double> s(x.size() + 3, 7.0), c(s);
    sincos_by_fours(
        n, [&](int i) { return x[static_cast<std::size_t>(i)]; }, s.data(), c.data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      CAPTURE(n);
      CAPTURE(i);
      if (!std::isfinite(x[i])) {
        CHECK((std::isnan(s[i]) && std::isnan(c[i])));
        continue;
      }
      double sine = std::sin(x[i]), cosine = std::cos(x[i]);
      if (std::fabs(x[i]) <= sincos_range) sincos(x[i], sine, cosine);
      CHECK(s[i] == sine);
      CHECK(c[i] == cosine);
    }
    for (std::size_t i = static_cast<std::size_t>(n + 3); i < s.size(); ++i) CHECK((s[i] == 7.0 && c[i] == 7.0));
  }
}
