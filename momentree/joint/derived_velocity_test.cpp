#include <doctest/doctest.h>

#include <momentree/joint/derived_velocity_laws.hpp>

TEST_CASE("(9) (16) (17) (22) (23) (24) (25) (26) (27) (39) derived steps in velocities equal the generic functions") {
  momentree::test::velocity_steps::laws<double>(1e-12);
}
