#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/model/model.hpp>

using namespace momentree;

namespace {

std::string verdict(double mass, const Sym3& inertia) {
  const MassProblem problem = check_mass(mass, inertia);
  return problem.what.empty() ? "sound" : problem.warning ? "odd" : "impossible";
}

BodySpec part(BodyId parent, const Sym3& inertia, double mass = 1, const Vec3& com = {}) {
  return {.name = "b", .mass = mass, .com = com, .inertia = inertia, .parent = parent, .joint = JointSpec{}};
}

}  // namespace

TEST_CASE("points, rods, plates and balls are valid at any scale") {
  for (double f : {1e-280, 1e-20, 1.0, 1e20, 1e280}) {
    CAPTURE(f);
    CHECK(verdict(1, diagonal(f)) == "sound");
    CHECK(verdict(1, diagonal(0, f, f)) == "sound");
    CHECK(verdict(1, diagonal(f, f, 2 * f)) == "sound");
    CHECK(verdict(1, diagonal(f, f, 2.01 * f)) == "odd");
    CHECK(verdict(1, diagonal(f, f, 2.1 * f)) == "impossible");
    CHECK(verdict(1, diagonal(f, -f, f)) == "impossible");
  }
  CHECK(verdict(1, {}) == "sound");
  CHECK(verdict(0, {}) == "sound");
  CHECK(verdict(0, diagonal(1)) == "impossible");
  CHECK(verdict(-1, {}) == "impossible");
}

TEST_CASE("a rod along any direction is valid; products too large for the moments are not") {
  // 1 − uuᵀ for u = (1, 1, 1)/√3
  CHECK(verdict(1, {2.0 / 3, 2.0 / 3, 2.0 / 3, -1.0 / 3, -1.0 / 3, -1.0 / 3}) == "sound");
  CHECK(verdict(1, {1, 1, 1, 2, 0, 0}) == "impossible");
  CHECK(verdict(1, {0, 0, 0, 1, 0, 0}) == "impossible");
}

TEST_CASE("an implausible inertia is a warning if the rigid group is valid, else an error") {
  const Sym3 odd = diagonal(1, 1, 3);
  std::vector<BodySpec> bodies{part(ground, diagonal(5)), part({0}, odd)};
  auto problems = check_masses(bodies);
  REQUIRE(problems.size() == 1);
  CHECK(problems[0].body == BodyId{1});
  CHECK(problems[0].problem.warning);

  bodies[0].inertia = diagonal(0.1);
  problems = check_masses(bodies);
  REQUIRE(problems.size() == 1);
  CHECK(!problems[0].problem.warning);

  // The distance between the parts counts: two masses 4 m apart along z compensate for it …
  bodies[1].at = {0, 0, 4};
  CHECK(check_masses(bodies).at(0).problem.warning);
  // … but not along x, which increases the largest moment as well.
  bodies[1].at = {0.01, 0, 0};
  CHECK(!check_masses(bodies).at(0).problem.warning);

  bodies[0].inertia = diagonal(5);
  bodies[1].joint = Revolute{};
  CHECK(!check_masses(bodies).at(0).problem.warning);  // no longer rigidly joined
}

TEST_CASE("bodies welded to the ground are separate groups") {
  const std::vector<BodySpec> bodies{part(ground, diagonal(5)), part(ground, diagonal(1, 1, 3))};
  REQUIRE(check_masses(bodies).size() == 1);
  CHECK(!check_masses(bodies)[0].problem.warning);
}
