#include <doctest/doctest.h>

#include <momentree/joint/derived_velocity_laws.hpp>

using namespace momentree;

TEST_CASE("(9) (16) (17) (22) (23) (24) (25) (26) (27) (39) derived steps in velocities with other scalars") {
  SUBCASE("counted") { test::velocity_steps::laws<Counted>(1e-12); }
  SUBCASE("lanes") { test::velocity_steps::laws<Pack<double, 2>>(1e-12); }
}
