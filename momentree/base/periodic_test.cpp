// Compared with decimal numbers as they are read.
#include <momentree/base/periodic.hpp>

#include <cmath>
#include <cstdlib>
#include <string>

#include <doctest/doctest.h>

using namespace momentree;

namespace {

// The decimal number digits · 10^-places.
double decimal(long long digits, int places) {
  return std::strtod((std::to_string(digits) + "e-" + std::to_string(places)).c_str(), nullptr);
}

}  // namespace

TEST_CASE("instants of a decimal period are the decimal numbers that a user writes") {
  for (const auto& [digits, places] :
       {std::pair{5LL, 2}, {1LL, 1}, {1LL, 3}, {7LL, 4}, {23LL, 2}, {125LL, 3}, {1'234'567LL, 9}}) {
    const Periodic rows(0, decimal(digits, places));
    double time = 0;
    for (long long k = 1; k <= 5000; ++k) {
      time = rows.first_after(time);
      CAPTURE(k);
      REQUIRE(time == decimal(k * digits, places));
      REQUIRE(rows.first_from(time) == time);
      REQUIRE(rows.first_from(std::nextafter(time, -HUGE_VAL)) == time);
      REQUIRE(rows.first_from(std::nextafter(time, HUGE_VAL)) == decimal((k + 1) * digits, places));
    }
  }
  CHECK(Periodic(0, 0.05).first_after(0.25) == 0.3);  // 6 * 0.05 is 0.30000000000000004
}

TEST_CASE("a first instant with other decimal places") {
  const Periodic beats(0.1, 0.23);
  double time = 0;
  for (long long k = 0; k < 1000; ++k) {
    time = beats.first_after(time);
    REQUIRE(time == decimal(10 + 23 * k, 2));
  }
  CHECK(Periodic(0.125, 1e-3).first_after(0.125) == 0.126);
  CHECK(Periodic(2, 0.7).first_from(5.5) == 5.5);
}

TEST_CASE("instants before zero, and before the first one") {
  CHECK(Periodic(0, 0.1).first_after(-0.3) == -0.2);
  CHECK(Periodic(0, 0.1).first_from(-0.3) == -0.3);
  CHECK(Periodic(0.5, 0.25).first_from(0.1) == 0.25);
}

TEST_CASE("periods that are not short decimals are multiplied") {
  const double third = 1.0 / 3;
  CHECK(Periodic(0, third).first_after(2 * third) == 1);
  const Periodic rows(0, 1.0 / 7);
  double time = 0;
  for (int k = 1; k < 1000; ++k) {
    time = rows.first_after(time);
    REQUIRE(time == k * (1.0 / 7));
  }
}

TEST_CASE("instants after a delay are decimal as well") {
  for (int from = 0; from < 100; ++from)
    for (int delay = 1; delay < 100; ++delay)
      REQUIRE(delayed(decimal(from, 2), decimal(delay, 1)) == decimal(from + 10 * delay, 2));
  CHECK(delayed(1.0 / 3, 0.1) == 1.0 / 3 + 0.1);
  for (const double time : {0.3, 1.0 / 3, 1e300}) {
    CHECK(delayed(time, 0) == time);
    CHECK(delayed(time, 1e-30) == time);
  }
}

TEST_CASE("where the clock does not resolve the period, time advances nevertheless") {
  for (const double late : {1e16, 1e17, 1e300}) CHECK(Periodic(0, 0.01).first_after(late) > late);
  for (const double period : {1e-300, 1e-30, 0.1, 1e30, 1e300}) {
    CHECK(Periodic(0, period).first_after(1) > 1);
    CHECK(Periodic(0, period).first_from(1) >= 1);
  }
}
