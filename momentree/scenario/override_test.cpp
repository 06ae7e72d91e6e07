#include <doctest/doctest.h>

#include <momentree/scenario/scenario.hpp>
#include <tests/bad_input.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::bad_input;

namespace {

ReadResult read(const std::vector<std::string>& overrides) {
  return read_scenario_text(pinned + "[[event]]\nat = 1\nbreak = \"m/a\"\n[world]\ngravity = [0, 0, 0]\n", "s.toml", overrides);
}

Scenario with(const std::string& override_text) {
  ReadResult result = read({override_text});
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return std::move(*result.scenario);
}

}  // namespace

TEST_CASE("an override replaces or adds a value by its dotted path") {
  CHECK(with("integrate.step=1e-4").integration.step == 1e-4);   // a table that did not exist
  CHECK(with("integrate.step=2 ms").integration.step == 0.002);  // not TOML: a string
  CHECK(with("integrate.step=\"3 ms\"").integration.step == 0.003);
  CHECK(with("mechanism.m.pose.xyz=[0,0,1]").model[BodyId{0}].at.position.z == 1);
  CHECK(with("mechanism.m.body.a.mass=7").model[BodyId{0}].mass == 7);
  CHECK(with("mechanism.0.body.\"a\".mass=7").model[BodyId{0}].mass == 7);
  CHECK(with("world.gravity.1=-9.81").model.gravity() == Vec3{0, -9.81, 0});
  CHECK(with("event.#1.at=0.5").events.at(0).time == 0.5);
  CHECK(with("event.0.at=0.5").events.at(0).time == 0.5);
  CHECK(with("title=a = b").title == "a = b");
  CHECK(with("world={ gravity = [1, 2, 3] }").model.gravity() == Vec3{1, 2, 3});
}

TEST_CASE("later overrides win") { CHECK(read({"integrate.step=1", "integrate.step=2"}).scenario->integration.step == 2); }

TEST_CASE("errors in an override point to it") {
  const auto refusal = [](const std::string& text) { return said(read({text})); };
  CHECK(refusal("integrate.step=0") == "--set integrate.step=0: error: step: must be greater than 0");
  CHECK(refusal("integrate.stp=1") == "--set integrate.stp=1: error: unknown key 'stp' in [integrate]; did you mean 'step'?");
  CHECK(refusal("integrate.step=3 m") ==
        "--set integrate.step=3 m: error: step: '3 m' is a length (m), not a time (s); for example 2, or \"2 s\"");
  CHECK(refusal("mechanism.m.body.b.mass=1") == "--set mechanism.m.body.b.mass=1: error: no entry of the list is named 'b'");
  CHECK(refusal("mechanism.7.name=x") == "--set mechanism.7.name=x: error: there is no entry '7' in a list of 1; the first is 0");
  CHECK(refusal("event.#2.at=1") == "--set event.#2.at=1: error: there is no entry '#2' in a list of 1; the first is #1");
  CHECK(refusal("world.gravity=[0,0,-1e300]") ==
        "--set world.gravity=[0,0,-1e300]: error: gravity: its magnitude is beyond the range of numbers");
  CHECK(refusal("world.gravity=[0, 0, -9.81").find("error: cannot read this") != std::string::npos);
  CHECK(refusal("mechanism.m.roots=999999999999999999999") ==
        "--set mechanism.m.roots=999999999999999999999: error: roots: expected a whole number from 1 to 1000000, found 1e+21");
  CHECK(refusal("format.x=1") == "--set format.x=1: error: 'format' is a number: it has no 'x'");
  const std::string usage = ": error: expected KEY=VALUE; for example integrate.step=1e-4 or mechanism.tug.pose.xyz=[0,0,1]";
  for (const char* text : {"", "=", "a", "a.=1", ".a=1", "a..b=1"}) CHECK(refusal(text) == "--set " + std::string(text) + usage);
  CHECK(refusal("\xff=1") == "--set \xEF\xBF\xBD=1" + usage);
  std::string deep = "a";
  for (int i = 0; i < 100; ++i) deep += ".a";
  CHECK(refusal(deep + "=1").find("expected KEY=VALUE") != std::string::npos);
}

TEST_CASE("an override cannot smuggle in a second key") {
  const std::string text = said(read({"title=\"a\"\nformat = 2"}));
  CHECK(text.find("error: title: '\"a\"\\nformat = 2' has an invisible character") != std::string::npos);
}
