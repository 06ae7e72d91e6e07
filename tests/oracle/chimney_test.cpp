// A chimney topples and breaks where its bending moment is largest: at a third of its height. The closed form for a
// uniform slender rod of length L that rotates about its foot, at the angle φ from upright:
// φ̈ = 3g/(2L) sin φ,   M(x) = μ g sin φ / (4L) · x (L − x)²;
// the time is an elliptic integral.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81, height = 30, density = 2000, start = 0.09, strength = 4e5;  // m, kg/m, rad, N m

Model chimney(int pieces) {
  Model model;
  const double l = height / pieces, m = density * l;
  BodyId last = ground;
  for (int k = 1; k <= pieces; ++k) {
    BodySpec piece{.name = "chimney/" + std::to_string(k),
                   .mass = m,
                   .com = {0, 0, l / 2},
                   .inertia = diagonal(m * l * l / 12, m * l * l / 12, m * l * l / 100),
                   .parent = last,
                   .at = {0, 0, k == 1 ? 0.0 : l}};
    if (k == 1) piece.joint = Revolute{.axis = y_axis}, piece.q = start;
    last = model.add(piece);
  }
  return model;
}

double context(double x, double angle) { return density * g * std::sin(angle) / (4 * height) * x * (height - x) * (height - x); }

/// Time at which the rod, released at `start`, is at that angle: from φ̇² = 3g/L (cos φ0 − cos φ), with sin((π − φ)/2) = k sin ψ.
double time_at(double angle) {
  const double k = std::cos(start / 2), end = std::asin(1.0), begin = std::asin(std::cos(angle / 2) / k);
  constexpr int pieces = 4000;
  double sum = 0;
  for (int i = 0; i <= pieces; ++i) {  // Simpson
    const double s = k * std::sin(begin + (end - begin) * i / pieces);
    sum += (i == 0 || i == pieces ? 1 : i % 2 == 1 ? 4 : 2) / std::sqrt(1 - s * s);
  }
  return sum * (end - begin) / pieces / 3 / std::sqrt(1.5 * g / height);
}

}  // namespace

TEST_CASE("the bending moment in a falling chimney is the closed form's at every joint") {
  const int pieces = 24;
  Simulation sim(chimney(pieces), {.step = 5e-3});
  REQUIRE(sim.run_until(3) == Status::ok);
  const double angle = sim.world().joint({0}).q[0];
  CHECK(angle > 0.3);
  CHECK(std::fabs(time_at(angle) - 3) < 1e-8);
  for (int k = 1; k < pieces; ++k) {
    const double exact = context(k * height / pieces, angle), found = norm(sim.world().joint_forces({k}).reaction.torque);
    CHECK(std::fabs(found - exact) < 1e-10 * context(height / 3, angle));
  }
}

TEST_CASE("a falling chimney breaks nearest to a third of its height, at the instant of the closed form") {
  for (const int pieces : {2, 3, 7, 10, 12, 16, 24, 30}) {
    CAPTURE(pieces);
    Simulation sim(chimney(pieces), {.step = 5e-3});
    int weakest = 1;
    for (int k = 1; k < pieces; ++k) {
      const std::string joint = "chimney/" + std::to_string(k + 1);
      sim.when(reaction_torque(joint).exceeds(strength)).then(break_joint(joint));
      if (context(k * height / pieces, 1) > context(weakest * height / pieces, 1)) weakest = k;
    }
    CHECK(std::fabs(static_cast<double>(weakest) / pieces - 1.0 / 3) <= 0.5 / pieces);
    REQUIRE(sim.run_until(4.5) == Status::ok);
    REQUIRE(sim.events().size() == 1);  // the upper part rotates freely; in the lower one the moment is a ninth
    const Event& event = sim.events()[0];
    CHECK(event.actions[0].text() == "break chimney/" + std::to_string(weakest + 1));
    const double angle = std::asin(strength / context(weakest * height / pieces, std::asin(1.0)));
    MESSAGE(pieces << " pieces: breaks at " << weakest << "/" << pieces << " of its height, " << event.time - time_at(angle)
                   << " s late");
    CHECK(std::fabs(event.time - time_at(angle)) < 1e-9);
    // After the break there is no bending moment in the upper part.
    for (int k = weakest + 1; k < pieces; ++k) CHECK(norm(sim.world().joint_forces({k}).reaction.torque) < 1e-6);
  }
}
