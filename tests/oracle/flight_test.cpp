// Free flight after a break: the centre of mass follows a parabola, the angular momentum about it is constant. Also the order of
// rk4 in the energy.
#include <cmath>
#include <numbers>

#include <tests/oracle/reference.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

/// Mass, centre of mass with its velocity, and angular momentum about it, of some bodies; world axes.
struct Part {
  double mass = 0;
  Vec3 com{}, velocity{}, angular{};
};
Part part_of(const World& world, const std::vector<BodyId>& bodies) {
  struct One {
    double mass;
    Vec3 com, velocity, spin;
  };
  std::vector<One> all;
  Part part;
  for (const BodyId b : bodies) {
    const BodyMotion& m = world.motions()[static_cast<std::size_t>(b.index)];
    const BodySpec& spec = world.model()[b];
    const Mat3 R = rotation_matrix(m.pose.rotation);
    const Vec3 arm = R * spec.com;
    all.push_back(
        {spec.mass, m.pose.position + arm, m.linear + cross(m.angular, arm), R * (spec.inertia * transpose_times(R, m.angular))});
    part.mass += spec.mass;
    part.com += spec.mass * all.back().com;
    part.velocity += spec.mass * all.back().velocity;
  }
  part.com = (1 / part.mass) * part.com;
  part.velocity = (1 / part.mass) * part.velocity;
  for (const One& one : all) part.angular += one.spin + one.mass * cross(one.com - part.com, one.velocity - part.velocity);
  return part;
}

/// An arm of five links with revolute, ball and universal joints, attached to the ground; no friction.
Model arm() {
  Model model;
  const Kind kinds[] = {Kind::revolute, Kind::ball, Kind::revolute, Kind::universal, Kind::revolute};
  BodyId last = ground;
  for (int k = 0; k < 5; ++k) {
    const Kind kind = kinds[k];
    BodySpec link{.name = "arm/" + std::to_string(k),
                  .mass = 1.0 + 0.3 * k,
                  .com = {0.2, 0.02, -0.01},
                  .inertia = {0.01, 0.03, 0.032, 0.001, -0.002, 0.0015},
                  .parent = last,
                  .at = k == 0 ? Pose{} : Pose{0.4, 0, 0}};
    link.joint = joint_of(kind, k % 2 ? x_axis : y_axis, z_axis);
    if (kind == Kind::ball)
      link.v = {0.4, -0.8, 0.6};
    else if (kind == Kind::universal)
      link.q = {0.3, -0.5}, link.v = {1.0, -0.7};
    else
      link.q = 0.2 * k, link.v = 0.5 - 0.3 * k;
    last = model.add(link);
  }
  return model;
}

/// Change of energy over 1 s.
double energy_error(const Model& model, double step) {
  Simulation run(model, {.step = step});
  const Totals start = run.world().totals();
  REQUIRE(run.run_until(1) == Status::ok);
  const Totals end = run.world().totals();
  return std::abs(end.kinetic + end.potential - start.kinetic - start.potential);
}

}  // namespace

TEST_CASE("the fallen part flies on a parabola and keeps its angular momentum to 1e-10") {
  const Model model = arm();
  const double broken_at = 0.3;
  for (const char* joint : {"arm/1", "arm/2", "arm/3"}) {
    CAPTURE(joint);
    Simulation run(model, {.step = 5e-5});
    run.at(broken_at).then(break_joint(joint));
    REQUIRE(run.run_until(broken_at) == Status::ok);
    REQUIRE(run.events().size() == 1);
    const std::vector<Mechanism> now = run.world().mechanisms();
    REQUIRE(now.size() == 2);
    const Mechanism& fallen = now[1];
    CHECK(fallen.root == model.child(model.joint(joint)));
    CHECK_FALSE(fallen.grounded);
    const std::vector<BodyId> bodies = fallen.bodies;
    CHECK(bodies.size() == static_cast<std::size_t>(5 - fallen.root.index));
    const Part start = part_of(run.world(), bodies);
    const double energy = run.world().totals().kinetic + run.world().totals().potential;
    for (int tenth = 1; tenth <= 10; ++tenth) {
      const double t = 0.1 * tenth;
      REQUIRE(run.run_until(broken_at + t) == Status::ok);
      const Part later = part_of(run.world(), bodies);
      const Vec3 expected = start.com + t * start.velocity + (t * t / 2) * model.gravity();
      check_near(later.com, expected, 1e-10, "centre of mass");
      check_near(later.velocity, start.velocity + t * model.gravity(), 1e-10, "its velocity");
      check_near(later.angular, start.angular, 1e-10 * norm(start.angular), "angular momentum");
      check_near(run.world().totals().kinetic + run.world().totals().potential, energy, 1e-10 * (1 + std::abs(energy)), "energy");
    }
  }
}

TEST_CASE("an event reports what a break conserved") {
  for (const char* joint : {"arm/0", "arm/2", "arm/4"}) {
    Simulation run(arm(), {.step = 1e-3});
    run.at(0.25).then(break_joint(joint));
    REQUIRE(run.run_until(0.5) == Status::ok);
    REQUIRE(run.events().size() == 1);
    const Event& e = run.events()[0];
    CHECK(e.time == 0.25);
    check_near(e.after.kinetic + e.after.potential + e.released, e.before.kinetic + e.before.potential,
               1e-12 * (1 + e.before.kinetic), "energy");
    check_near(e.after.linear, e.before.linear, 1e-12 * (1 + norm(e.before.linear)), "linear momentum");
    check_near(e.after.angular, e.before.angular, 1e-12 * (1 + norm(e.before.angular)), "angular momentum");
    CHECK(e.before.kinetic > 1e-3);
    CHECK(norm(e.before.angular) > 1e-2);
  }
}

TEST_CASE("the energy error of rk4 falls with the fourth power of the step or faster, on one link and on two") {
  for (const int links : {1, 2}) {
    CAPTURE(links);
    Model model({.gravity = {0, -9.81, 0}});
    BodyId last = ground;
    for (int k = 0; k < links; ++k)
      last = model.add({.name = std::to_string(k),
                        .mass = 1,
                        .com = {0.5, 0, 0},
                        .inertia = diagonal(0.001, 1.0 / 12, 1.0 / 12),
                        .parent = last,
                        .at = {k == 0 ? 0.0 : 1.0, 0, 0},
                        .joint = joint_of(Kind::revolute),
                        .q = k == 0 ? 0.3 : 0.9});
    double coarse = energy_error(model, 0.02);
    for (double step = 0.01; step > 0.002; step /= 2) {
      const double fine = energy_error(model, step), slope = std::log2(coarse / fine);
      MESSAGE(links << " links, step " << step << " s: error " << fine << " J, slope " << slope);
      CHECK(slope >= 3.8);
      coarse = fine;
    }
  }
}
