// Locks against closed forms and a reference trajectory: velocities, energies and impulses at the instant, and half a second
// later.
#include <string>

#include <momentree/joint/kinds.hpp>

#include <tests/oracle/reference.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

Model double_pendulum(const nlohmann::json& data) {
  Model model({.gravity = vec3_of(data["model"]["gravity"])});
  const auto& start = data["samples"][0]["trees"][0];
  for (const auto& b : data["model"]["bodies"]) {
    const std::string name = b["name"];
    const auto& i = b["inertia"];
    BodySpec body{.name = name, .mass = b["mass"], .com = vec3_of(b["com"])};
    body.inertia = {i[0][0], i[1][1], i[2][2], i[0][1], i[0][2], i[1][2]};
    if (!b["parent"].is_null()) body.parent = model.body(b["parent"].get<std::string>());
    body.at = {vec3_of(b["Xtree"]["pos"]), quat_of(b["Xtree"]["quat"])};
    body.joint = joint_of(Kind::revolute, vec3_of(b["joint"]["axis"]));
    body.q = values_of(start[name]["q"]);
    body.v = values_of(start[name]["u"]);
    model.add(body);
  }
  return model;
}

void compare(const World& world, const nlohmann::json& sample, double bound) {
  for (const auto& [name, pose] : sample["world_pose"].items()) {
    const BodyId body = world.model().body(name);
    const BodyMotion& m = world.motions()[static_cast<std::size_t>(body.index)];
    const Vec3 arm = rotation_matrix(m.pose.rotation) * world.model()[body].com;
    check_near(m.pose.position + arm, vec3_of(pose["com"]), bound, name + " com");
    check_near(m.linear + cross(m.angular, arm), vec3_of(pose["vel"]), bound, name + " velocity");
    check_near(m.angular, vec3_of(pose["omega"]), bound, name + " angular velocity");
    CHECK(apart(m.pose.rotation, quat_of(pose["quat"])) <= bound);
  }
  check_near(world.totals().kinetic, sample["kinetic"], bound, "kinetic energy");
}

}  // namespace

TEST_CASE("a joint of a swinging double pendulum locks: the reference trajectory, at the instant and half a second later") {
  const auto data = reference("lock_double_pendulum.json");
  for (const auto& c : data["cases"]) {
    const std::string joint = c["lock"];
    CAPTURE(joint);
    Simulation sim(double_pendulum(data), {.step = 5e-4});
    sim.at(c["after"]["t"]).then(lock(joint));
    REQUIRE(sim.run_until(c["after"]["t"]) == Status::ok);
    compare(sim.world(), c["after"], 1e-10);
    const Event& e = sim.events().at(0);
    check_near(e.lost, c["energy_loss"], 1e-10, "energy lost");
    for (const auto& [name, S] : e.impulse)
      for (std::size_t i = 0; i < 6; ++i) check_near(S[i], c["impulse_wrench"][name][i], 1e-10, name + " impulse");
    REQUIRE(sim.run_until(c["at_t1"]["t"]) == Status::ok);
    compare(sim.world(), c["at_t1"], 1e-10);
  }
}

TEST_CASE("locks of two rods: the closed form") {
  const auto data = reference("closed_forms.json")["lock_double_pendulum_rods"];
  constexpr double degree = 3.14159265358979323846 / 180;
  for (const auto& c : data["values"]) {
    const double th1 = c["th1_deg"].get<double>() * degree, th2 = c["th2_deg"].get<double>() * degree;
    const double w1 = c["w1"], w2 = c["w2"];
    Model model({.gravity = {}});
    const auto rod = [&](const char* name, BodyId parent, double at, double q, double v) {
      return model.add({.name = name,
                        .mass = 1,
                        .com = {0.5, 0, 0},
                        .inertia = diagonal(0, 1.0 / 12, 1.0 / 12),
                        .parent = parent,
                        .at = {at, 0, 0},
                        .joint = Revolute{},
                        .q = q,
                        .v = v});
    };
    const BodyId inner = rod("inner", ground, 0, th1, w1);
    rod("outer", inner, 1, th2 - th1, w2 - w1);
    Simulation elbow(model), base(model);
    const Event at_elbow = elbow.apply(lock("outer")), at_base = base.apply(lock("inner"));
    check_near(at_elbow.before.kinetic, c["T_before"], 1e-14, "before");
    check_near(at_elbow.after.kinetic, c["lock_elbow"]["T_after"], 1e-14, "after a lock of the elbow");
    check_near(at_elbow.lost, c["lock_elbow"]["loss"], 1e-14, "lost at the elbow");
    check_near(elbow.world().motions()[1].angular.z, c["lock_elbow"]["omega"], 1e-14, "common speed");
    check_near(at_base.after.kinetic, c["lock_base"]["T_after"], 1e-14, "after a lock of the base");
    check_near(at_base.lost, c["lock_base"]["loss"], 1e-14, "lost at the base");
    check_near(base.world().motions()[1].angular.z, c["lock_base"]["w2"], 1e-14, "outer rod");
  }
}
