#include <doctest/doctest.h>

#include <cmath>

#include <momentree/base/error.hpp>
#include <momentree/math/signal.hpp>

namespace momentree {

TEST_CASE("signals: constant, sine, table") {
  CHECK(Signal(3).value(7) == 3);
  CHECK(Signal(3).constant());
  const Signal s = Signal::sine(2, 0.25, 0.1, 1);
  CHECK(s.value(1) == doctest::Approx(1 + 2 * std::cos(0.1)));
  CHECK(s.rate(1) == doctest::Approx((s.value(1 + 1e-6) - s.value(1 - 1e-6)) / 2e-6));
  const Signal t = Signal::table({{1, 2}, {2, 4}, {4, 0}});
  CHECK(t.value(0) == 2);
  CHECK(t.value(1.5) == 3);
  CHECK(t.value(3) == 2);
  CHECK(t.value(9) == 0);
  CHECK(t.rate(0.5) == 0);
  CHECK(t.rate(2) == -2);
  CHECK(t.rate(4) == 0);
  CHECK(t.next_bend(0) == 1);
  CHECK(t.next_bend(1) == 2);
  CHECK(t.next_bend(4) == HUGE_VAL);
  CHECK(t == Signal::table({{1, 2}, {2, 4}, {4, 0}}));
  CHECK_FALSE(t == s);
  CHECK_THROWS_AS(Signal::table({}), Error);
  CHECK_THROWS_AS(Signal::table({{1, 2}, {1, 3}}), Error);
  CHECK_THROWS_AS(Signal::table({{1, NAN}}), Error);
  CHECK_THROWS_AS(Signal::sine(1, HUGE_VAL), Error);
}

TEST_CASE("curves: rates are those of their values, without jumps at the entries of a table") {
  const Curve table(Signal::table({{0, 1}, {0.5, 2}, {1.5, -1}, {2, 0}, {2.25, 0.5}}));
  const Curve sine(Signal::sine(0.5, 2, 0.3, 0.1));
  for (const Curve& c : {table, sine}) {
    const double h = 1e-5;
    for (double t = -0.2; t < 2.5; t += 0.0317) {
      const Curve::Point before = c.at(t - h), at = c.at(t), after = c.at(t + h);
      CHECK(at.rate == doctest::Approx((after.value - before.value) / (2 * h)).epsilon(1e-6).scale(1));
      CHECK(at.acceleration == doctest::Approx((after.rate - before.rate) / (2 * h)).epsilon(1e-4).scale(10));
    }
  }
  for (const Signal::Knot& k : table.signal().knots()) {
    const double e = 1e-9;
    CHECK(table.at(k.time).value == doctest::Approx(k.value));
    CHECK(std::fabs(table.at(k.time - e).rate - table.at(k.time + e).rate) < 1e-6);
    if (k.time > 0 && k.time < 2.25)
      CHECK(std::fabs(table.at(k.time - e).acceleration - table.at(k.time + e).acceleration) < 1e-5);
  }
  CHECK(table.at(-1).rate == 0);
  CHECK(std::fabs(table.at(0).rate) < 1e-14);
  CHECK(std::fabs(table.at(2.25 - 1e-12).rate) < 1e-9);
}

}  // namespace momentree
