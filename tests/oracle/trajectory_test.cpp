// Reference trajectories: a spatial chain of three bodies with friction, and a heavy top.
#include <string>

#include <tests/oracle/reference.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

Kind kind_of(const std::string& name) {
  const KindInfo* info = find_kind(name);
  REQUIRE(info);
  return info->kind;
}

Model model_of(const nlohmann::json& data) {
  Model model({.gravity = vec3_of(data["model"]["gravity"])});
  const auto& start = data["samples"][0]["trees"][0];
  for (const auto& b : data["model"]["bodies"]) {
    const std::string name = b["name"];
    BodySpec body{.name = name, .mass = b["mass"], .com = vec3_of(b["com"])};
    const auto& i = b["inertia"];
    body.inertia = {i[0][0], i[1][1], i[2][2], i[0][1], i[0][2], i[1][2]};
    if (!b["parent"].is_null()) body.parent = model.body(b["parent"].get<std::string>());
    body.at = {vec3_of(b["Xtree"]["pos"]), quat_of(b["Xtree"]["quat"])};
    body.joint.kind = kind_of(b["joint"]["kind"]);
    if (b["joint"].contains("axis")) body.joint.axis = vec3_of(b["joint"]["axis"]);
    if (b["joint"].contains("axis2")) body.joint.axis2 = vec3_of(b["joint"]["axis2"]);
    body.joint.parameters.damping = b["joint"]["damping"].get<double>();
    body.q = values_of(start[name]["q"]);
    body.v = values_of(start[name]["u"]);
    model.add(body);
  }
  return model;
}

/// Compares with every sample of the file, to 1e-8 of each number's size (of 1 for small ones).
void follow(const std::string& file, double step) {
  const auto data = reference(file);
  const Model model = model_of(data);
  Simulation run(model, {.step = step});
  const auto near = [](double measured, double expected, const std::string& what) {
    check_near(measured, expected, 1e-8 * std::max(1.0, std::abs(expected)), what);
  };
  int samples = 0;
  for (const auto& row : data["samples"]) {
    REQUIRE(run.run_until(row["t"]) == Status::ok);
    CAPTURE(run.time());
    ++samples;
    for (const auto& [name, joint] : row["trees"][0].items()) {
      const BodyId body = model.body(name);
      const JointView view = run.world().joint({body.index});
      const bool quaternion = view.kind == Kind::ball;
      if (quaternion) CHECK(apart(Quat{view.q[0], view.q[1], view.q[2], view.q[3]}, quat_of(joint["q"])) <= 1e-8);
      for (std::size_t i = 0; i < view.q.size() && !quaternion; ++i) near(view.q[i], joint["q"][i], name + " q");
      for (std::size_t i = 0; i < view.v.size(); ++i) {
        near(view.v[i], joint["u"][i], name + " v");
        near(view.p[i], joint["p"][i], name + " p");
      }
      const auto& pose = row["world_pose"][name];
      const BodyMotion& m = run.world().motions()[static_cast<std::size_t>(body.index)];
      const Vec3 com = m.pose * model[body].com;
      check_near(com, vec3_of(pose["com"]), 1e-8, name + " centre of mass");
      CHECK(apart(m.pose.rotation, quat_of(pose["quat"])) <= 1e-8);
      const double scale = std::max(1.0, norm(vec3_of(pose["omega"])));
      check_near(m.linear + cross(m.angular, com - m.pose.position), vec3_of(pose["vel"]), 1e-8 * scale, name + " velocity");
      check_near(m.angular, vec3_of(pose["omega"]), 1e-8 * scale, name + " angular velocity");
    }
    const Totals sum = run.world().totals();
    near(sum.kinetic, row["kinetic"], "kinetic energy");
    near(sum.potential, row["potential"], "potential energy");
    check_near(sum.linear, vec3_of(row["linear_momentum"]), 1e-8, "linear momentum");
    check_near(sum.angular, vec3_of(row["angular_momentum_world_origin"]), 1e-8, "angular momentum");
  }
  CHECK(samples == static_cast<int>(data["samples"].size()));
}

}  // namespace

TEST_CASE("a spatial chain: universal, ball, revolute, with friction") { follow("spatial_chain.json", 1e-4); }
TEST_CASE("a heavy top released at rest") { follow("heavy_top.json", 5e-5); }
