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

TEST_CASE("ramps, and tables with free ends") {
  const Signal ramp = Signal::ramp(3, -1);
  CHECK(ramp.value(2) == 5);
  CHECK(ramp.rate(2) == 3);
  CHECK_FALSE(ramp.constant());
  CHECK_FALSE(ramp == Signal(-1));
  CHECK(Curve(ramp).at(2).value == 5);
  CHECK(Curve(ramp).at(-7).rate == 3);
  CHECK(Curve(ramp).at(2).acceleration == 0);
  const Signal here = Signal::ramp_from_here(3);
  CHECK(here.from_here());
  CHECK(here.begun_at(0.5, 2).value(2) == doctest::Approx(0.5));
  CHECK(here.begun_at(0.5, 2).from_here());
  CHECK(ramp.begun_at(0.5, 2) == ramp);
  CHECK_THROWS_AS(Signal::ramp(NAN, 0), Error);
  CHECK_THROWS_AS(Signal::table({{0, 1}}, Signal::Ends::free), Error);

  // Two entries: a straight line.
  const Curve line(Signal::table({{1, 2}, {2, 5}}, Signal::Ends::free));
  for (const double t : {-3.0, 1.0, 1.3, 2.0, 7.0}) {
    CHECK(line.at(t).value == doctest::Approx(2 + 3 * (t - 1)));
    CHECK(line.at(t).rate == doctest::Approx(3));
    CHECK(std::fabs(line.at(t).acceleration) < 1e-12);
  }
  // Value, rate and acceleration are continuous everywhere; the acceleration is zero at the ends.
  const Signal table = Signal::table({{0, 1}, {0.5, 2}, {1.5, -1}, {2, 0}, {2.25, 0.5}}, Signal::Ends::free);
  const Curve curve(table);
  const double e = 1e-9;
  for (const Signal::Knot& k : table.knots()) {
    CHECK(curve.at(k.time).value == doctest::Approx(k.value));
    CHECK(std::fabs(curve.at(k.time - e).rate - curve.at(k.time + e).rate) < 1e-6);
    CHECK(std::fabs(curve.at(k.time - e).acceleration - curve.at(k.time + e).acceleration) < 1e-5);
  }
  CHECK(std::fabs(curve.at(e).acceleration) < 1e-6);
  CHECK(std::fabs(curve.at(2.25 - e).acceleration) < 1e-6);
  CHECK(curve.at(5).rate == curve.at(2.25).rate);
  CHECK(curve.at(5).value == doctest::Approx(0.5 + 2.75 * curve.at(2.25).rate));
  CHECK_FALSE(table == Signal::table({{0, 1}, {0.5, 2}, {1.5, -1}, {2, 0}, {2.25, 0.5}}));
}

}  // namespace momentree
