#include <momentree/math/pack.hpp>

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

using namespace momentree;

namespace {

// Packs wider than this build's registers are tested with the kernels that are compiled for them: batch/,
// tests/oracle/lanes_test.
#if defined(__AVX2__)
using Doubles = Pack<double, 4>;
using Floats = Pack<float, 8>;
#else
using Doubles = Pack<double, 2>;
using Floats = Pack<float, 4>;
#endif

struct Random {
  unsigned long long state = 88172645463325252ULL;
  double between(double low, double high) {
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return low + (high - low) * static_cast<double>(state >> 11) * 0x1p-53;
  }
};

template <class P>
void check_arithmetic() {
  using S = typename P::Scalar;
  Random random;
  for (int round = 0; round < 100; ++round) {
    double a[P::lanes], b[P::lanes], out[P::lanes];
    for (int i = 0; i < P::lanes; ++i) a[i] = random.between(-3, 3), b[i] = random.between(0.5, 3);
    const double c = random.between(-2, 2);
    const P x = P::load(a), y = P::load(b);
    const auto check = [&](const P& got, auto want) {
      got.store(out);
      for (int i = 0; i < P::lanes; ++i) {
        const S expected = want(static_cast<S>(a[i]), static_cast<S>(b[i]), static_cast<S>(c));
        CHECK(got[i] == expected);
        CHECK(out[i] == static_cast<double>(expected));
      }
    };
    check(x + y, [](S u, S v, S) { return u + v; });
    check(x - y, [](S u, S v, S) { return u - v; });
    check(x * y, [](S u, S v, S) { return u * v; });
    check(x / y, [](S u, S v, S) { return u / v; });
    check(-x, [](S u, S, S) { return -u; });
    check(x + c, [](S u, S, S k) { return u + k; });
    check(x - c, [](S u, S, S k) { return u - k; });
    check(x * c, [](S u, S, S k) { return u * k; });
    check(x / c, [](S u, S, S k) { return u / k; });
    check(c + y, [](S, S v, S k) { return k + v; });
    check(c - y, [](S, S v, S k) { return k - v; });
    check(c * y, [](S, S v, S k) { return k * v; });
    check(c / y, [](S, S v, S k) { return k / v; });
    P z = x;
    z += y;
    check(z, [](S u, S v, S) { return u + v; });
    z = x;
    z -= c;
    check(z, [](S u, S, S k) { return u - k; });
    z = x;
    z *= y;
    check(z, [](S u, S v, S) { return u * v; });
    check(select(within(x, 1), x, y), [](S u, S v, S) { return std::fabs(u) <= 1 ? u : v; });
  }
}

}  // namespace

TEST_CASE("arithmetic of packs is that of their scalar in every lane") {
  check_arithmetic<Doubles>();
  check_arithmetic<Floats>();
}

TEST_CASE("NaN is within no bounds") {
  Doubles a(0);
  a.set(1, std::numeric_limits<double>::quiet_NaN());
  const auto mask = within(a, std::numeric_limits<double>::infinity());
  CHECK(mask[0] != 0);
  CHECK(mask[1] == 0);
}

TEST_CASE("sine and cosine of doubles have the bits of those of one angle") {
  Random random;
  for (int round = 0; round < 20000; ++round) {
    const double range = round % 3 == 0 ? 3.2 : round % 3 == 1 ? 100.0 : sincos_range;
    double x[Doubles::lanes];
    for (double& angle : x) angle = random.between(-range, range);
    Doubles s, c;
    sincos(Doubles::load(x), s, c);
    for (int i = 0; i < Doubles::lanes; ++i) {
      double sine = 0, cosine = 0;
      sincos(x[i], sine, cosine);
      REQUIRE(s[i] == sine);
      REQUIRE(c[i] == cosine);
    }
  }
}

TEST_CASE("sine and cosine of floats are accurate to their last digits") {
  Random random;
  double worst = 0;
  for (int round = 0; round < 20000; ++round) {
    const double range = round % 2 == 0 ? 3.2 : pack_sincos_range<float>;
    Floats x, s, c;
    for (int i = 0; i < Floats::lanes; ++i) x.set(i, random.between(-range, range));
    sincos(x, s, c);
    for (int i = 0; i < Floats::lanes; ++i) {
      worst = std::fmax(worst, std::fabs(static_cast<double>(s[i]) - std::sin(static_cast<double>(x[i]))));
      worst = std::fmax(worst, std::fabs(static_cast<double>(c[i]) - std::cos(static_cast<double>(x[i]))));
    }
  }
  CHECK(worst < 1.2e-7);
}

TEST_CASE("a lane with a large angle or NaN changes no bit of the others") {
  Doubles x[2], s[2], c[2], alone_s[2], alone_c[2];
  x[0] = Doubles(0.5), x[1] = Doubles(-2.5);
  sincos(2, x, alone_s, alone_c);
  x[1].set(1, 1e9);
  sincos(2, x, s, c);
  CHECK(s[1][1] == std::sin(1e9));
  CHECK(c[1][1] == std::cos(1e9));
  CHECK(s[0][0] == alone_s[0][0]);
  CHECK(s[0][1] == alone_s[0][1]);
  CHECK(c[1][0] == alone_c[1][0]);
  x[0].set(0, std::numeric_limits<double>::quiet_NaN());
  sincos(2, x, s, c);
  CHECK(std::isnan(s[0][0]));
  CHECK(s[0][1] == alone_s[0][1]);
  CHECK(s[1][1] == std::sin(1e9));
}
