#include <clocale>
#include <string>

#include <doctest/doctest.h>

#include <momentree/base/units.hpp>

using namespace momentree;

namespace {

double value(std::string_view text, const Dimension& expected) {
  QuantityProblem problem;
  const auto read = parse_quantity(text, expected, problem);
  INFO(problem.what, "; ", problem.hint);
  REQUIRE(read);
  return *read;
}

std::string refusal(std::string_view text, const Dimension& expected) {
  QuantityProblem problem;
  if (const auto read = parse_quantity(text, expected, problem)) return "accepted as " + std::to_string(*read);
  return problem.what + "; " + problem.hint;
}

}  // namespace

TEST_CASE("decimal units give the double nearest to the decimal value") {
  CHECK(value("5 cm", dimension::length) == 0.05);
  CHECK(value("10 g", dimension::mass) == 0.01);
  CHECK(value("1 ms", dimension::time) == 0.001);
  CHECK(value("0.1 ms", dimension::time) == 0.0001);
  CHECK(value("1.8 s", dimension::time) == 1.8);
  CHECK(value("20.83 g cm^2", dimension::inertia) == 20.83e-7);
  CHECK(value("0.83 g cm^2", dimension::inertia) == 0.83e-7);
  CHECK(value("-9.81 m/s^2", dimension::acceleration) == -9.81);
  CHECK(value("1e-5 N m s", dimension::torque / dimension::angular_speed) == 1e-5);
  CHECK(value("12 in", dimension::length) == value("1 ft", dimension::length));
}

TEST_CASE("units multiply by space or star, divide by one slash, and take powers") {
  CHECK(value("2 N*m*s/rad", dimension::torque / dimension::angular_speed) == 2);
  CHECK(value("  3\tkg  m^2 ", dimension::inertia) == 3);
  CHECK(value("3 kg m^2 s^-2", dimension::torque) == 3);
  CHECK(value("6 J", dimension::torque) == 6);
  CHECK(value("4 1/s^2 * m", dimension::number / dimension::time / dimension::time / dimension::length) == 4);
  CHECK(value("5 /s^2", Dimension{.s = -2}) == 5);
  CHECK(value("+7 mN/mm", dimension::force / dimension::length) == 7);
  CHECK(value("180 deg", dimension::angle) == doctest::Approx(3.14159265358979));
  CHECK(value("60 rpm", dimension::angular_speed) == value("1 rev/s", dimension::angular_speed));
  CHECK(value("2 µm", dimension::length) == 2e-6);
}

TEST_CASE("radians may be left out next to a mass, and only there") {
  CHECK(value("3 N m", dimension::torque / dimension::angle) == 3);
  CHECK(value("3 N m/rad", dimension::torque / dimension::angle) == 3);
  CHECK(refusal("3 N m/rad", dimension::torque).find("not a torque") != std::string::npos);
  CHECK(refusal("3 1/s", dimension::angular_speed).find("not an angular speed (rad/s)") != std::string::npos);
  CHECK(refusal("3 rad", dimension::number).find("is an angle (rad), not a number without unit") != std::string::npos);
}

TEST_CASE("values that are not a number with the right unit are refused, with a suggestion") {
  struct Case {
    const char* text;
    Dimension expected;
    const char* refusal;
  };
  const Case cases[] = {
      {"3 m", dimension::mass, "'3 m' is a length (m), not a mass (kg); for example 0.2, or \"200 g\""},
      {"3 m^5", dimension::mass, "'3 m^5' is a quantity in m^5, not a mass (kg); for example 0.2, or \"200 g\""},
      {"3", dimension::mass, "'3' has no unit; write 3 without quotes, or \"3 kg\""},
      {"90", dimension::angle, "'90' has no unit; write \"90 deg\", or \"90 rad\""},
      {"1e-6", dimension::number, "'1e-6' is in quotes; write 1e-6 without them"},
      {"90°", dimension::angle, "'90°' runs number and unit together; write \"90 deg\""},
      {"pi/2", dimension::angle,
       "'pi/2' does not begin with a number; a value can't be a formula: write degrees, as in \"90 deg\", or the number itself"},
      {"abc", dimension::time, "'abc' does not begin with a number; expected a time (s), for example 2, or \"2 s\""},
      {"50 Hz", dimension::time, "'50 Hz' is a frequency (Hz), not a time (s); for example 2, or \"2 s\""},
      {"", dimension::mass, "'' does not begin with a number; expected a mass (kg), for example 0.2, or \"200 g\""},
      {"kg", dimension::mass, "'kg' does not begin with a number; expected a mass (kg), for example 0.2, or \"200 g\""},
      {"nan kg", dimension::mass, "'nan kg' does not begin with a number; expected a mass (kg), for example 0.2, or \"200 g\""},
      {"-inf kg", dimension::mass, "'-inf kg' does not begin with a number; expected a mass (kg), for example 0.2, or \"200 g\""},
      {"+-1 kg", dimension::mass, "'+-1 kg' does not begin with a number; expected a mass (kg), for example 0.2, or \"200 g\""},
      {"- 1 kg", dimension::mass, "'- 1 kg' does not begin with a number; expected a mass (kg), for example 0.2, or \"200 g\""},
      {"1,5 kg", dimension::mass, "'1,5 kg' has a comma in its number; the decimal sign is a point"},
      {"1.0kg", dimension::mass, "'1.0kg' runs number and unit together; write \"1.0 kg\""},
      {"1e999 kg", dimension::mass, "'1e999 kg' is outside the range of numbers; they go up to 1.8e308"},
      {"1e308 km", dimension::length, "'1e308 km' is outside the range of numbers; "},
      {"0x10 kg", dimension::mass, "'0x10 kg' runs number and unit together; write \"0 x10 kg\""},
      {"3 Nm", dimension::torque, "unknown unit 'Nm'; write N m"},
      {"3 degrees", dimension::angle, "unknown unit 'degrees'; write deg"},
      {"3 cm2", dimension::length, "unknown unit 'cm2'; write cm^2"},
      {"3 um3", dimension::length, "unknown unit 'um3'; powers are written with ^: um^3"},
      {"3 mradd", dimension::angle, "unknown unit 'mradd'; did you mean 'mrad'?"},
      {"3 m/s/s", dimension::acceleration,
       "more than one '/' in a unit; use one '/': everything after it divides, as in \"kg/m s^2\""},
      {"3 m/", dimension::speed, "a unit is missing; units are joined by a space, '*' or one '/', as in \"N m s\" or \"m/s^2\""},
      {"3 m**s", dimension::speed,
       "a unit is missing; units are joined by a space, '*' or one '/', as in \"N m s\" or \"m/s^2\""},
      {"3 ^2", dimension::length, "a unit is missing; units are joined by a space, '*' or one '/', as in \"N m s\" or \"m/s^2\""},
      {"3 m^x", dimension::length, "a power is a whole number from -9 to 9; for example \"cm^2\""},
      {"3 m^99", dimension::length, "a power is a whole number from -9 to 9; for example \"cm^2\""},
      {"3 m^2.5", dimension::length, "a power is a whole number from -9 to 9; for example \"cm^2\""},
  };
  for (const Case& c : cases) {
    CAPTURE(c.text);
    CHECK(refusal(c.text, c.expected) == c.refusal);
  }
  std::string endless = "1";
  for (int i = 0; i < 60; ++i) endless += " m";
  CHECK(refusal(endless, dimension::length).find("not a length") != std::string::npos);
  CHECK(refusal("1" + std::string(100'000, ' ') + "m", dimension::length).find("at most 200") != std::string::npos);
}

TEST_CASE("numbers read the same in a locale with a decimal comma") {
  const char* before = std::setlocale(LC_ALL, nullptr);
  const std::string keep = before ? before : "C";
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "C"}) {
    if (!std::setlocale(LC_ALL, name)) continue;  // not installed everywhere
    CHECK(value("1.5 kg", dimension::mass) == 1.5);
  }
  std::setlocale(LC_ALL, keep.c_str());
}

TEST_CASE("the number and the unit of a quantity as written") {
  const auto parts = [](const char* text) {
    const auto found = split_quantity(text);
    return found ? std::to_string(found->number) + '|' + found->unit : "none";
  };
  CHECK(parts("0.5 ms") == "0.500000|ms");
  CHECK(parts("-2  N m ") == "-2.000000|N m");
  for (const char* text : {"", "rk4", "2", "2 apples", "2ms", "a 2 ms", "1,5 ms"}) CHECK(parts(text) == "none");
}
