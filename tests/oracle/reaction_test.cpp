// Joint wrenches and accelerations against closed forms and reference data.
#include <cmath>
#include <numbers>
#include <string>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>
#include <tests/oracle/reference.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

constexpr double degree = std::numbers::pi / 180;

/// The start of a model with accelerations. Reactions are in world axes, computed from the poses.
struct Instant {
  Tree tree;
  State state;
  Workspace<double> workspace;
  explicit Instant(const Model& model) : tree(compile(model)), state(start_state(model, tree)), workspace(tree) {
    locate_bodies(tree, state, workspace);
    accelerate(tree, state, workspace);
  }
  Force<double> reaction(int b) const { return as_force(momentree::reaction(tree, state, workspace, tree.inboard_joint({b}))); }
  Vec3 force(int b) const {
    return rotation_matrix(user_pose(tree, workspace.bodies[static_cast<std::size_t>(b)], b).rotation) * reaction(b).l;
  }
};

/// The same model with other start values.
Model with_start(const Model& model, const nlohmann::json& start) {
  Model out({.gravity = model.gravity()});
  for (BodySpec body : model.bodies()) {
    body.q = values_of(start[body.name]["q"]);
    body.v = values_of(start[body.name]["u"]);
    out.add(body);
  }
  return out;
}

}  // namespace

TEST_CASE("(32) the reaction of the joint of a swinging rod") {
  const auto data = reference("closed_forms.json")["rod_pendulum_reactions"];
  int rows = 0;
  for (const auto& row : data["values"]) {
    ++rows;
    const double m = 2.5, g = 9.81, angle = row["theta_deg"].get<double>() * degree;
    Model model({.gravity = {0, -g, 0}});
    model.add({.name = "rod",
               .mass = m,
               .com = {0, -0.5, 0},
               .inertia = diagonal(m / 12, 0, m / 12),
               .joint = Revolute{},
               .q = angle,
               .v = row["omega"].get<double>()});
    const Instant at(model);
    const Force<double> W = at.reaction(0);  // rod axes: y from the tip to the joint
    const double w = row["omega"];           // for length and mass 1, g = 9.81
    CHECK(w * w ==
          doctest::Approx(3 * g * (std::cos(angle) - std::cos(row["theta0_deg"].get<double>() * degree))).epsilon(1e-12));
    check_near(W.l.y / (m * g), row["axial_over_mg"], 1e-12, "along the rod");
    check_near(std::abs(W.l.x) / (m * g), row["transverse_over_mg"], 1e-12, "across the rod");
    check_near(W.h, {}, 1e-12, "torque");
  }
  CHECK(rows == 4);
}

TEST_CASE("(32) the tension of a pendulum's string") {
  const auto data = reference("closed_forms.json")["A01_simple_pendulum"];
  for (const auto& row : data["values"]) {
    Model model({.gravity = {0, -9.81, 0}});
    model.add({.name = "p",
               .mass = 1,
               .com = {0, -1, 0},
               .joint = Revolute{},
               .q = row["theta"].get<double>(),
               .v = row["thetadot"].get<double>()});
    const Instant at(model);
    check_near(at.reaction(0).l.y, row["tension"], 1e-12 * row["tension"].get<double>(), "tension");
    check_near(at.workspace.a[0], -9.81 * row["x"].get<double>(), 1e-11, "acceleration");
  }
}

TEST_CASE("(32) a hanging chain that a force pulls sideways at its tip rests in its closed form") {
  const auto data = reference("closed_forms.json")["static_chain_tip_force"];
  const int n = data["params"]["N"];
  const double m = data["params"]["m"], L = data["params"]["L"], H = data["params"]["H"], g = data["params"]["g"];
  Model model({.gravity = {0, -g, 0}});
  BodyId last = ground;
  double turned = 0;
  for (int k = 0; k < n; ++k) {
    const double angle = data["phi"][static_cast<std::size_t>(k)];
    last = model.add({.name = "c/" + std::to_string(k),
                      .mass = m,
                      .com = {0, -L / 2, 0},
                      .inertia = diagonal(m * L * L / 12, 0, m * L * L / 12),
                      .parent = last,
                      .at = {0, k == 0 ? 0 : -L, 0},
                      .joint = Revolute{},
                      .q = angle - turned});
    turned = angle;
  }
  // A drive pushes against an almost massless body, which flies away along x.
  model.add({.name = "c/pushed",
             .mass = 1e-15,
             .parent = last,
             .at = Pose{{0, -L, 0}, from_axis_angle(z_axis, -turned)},
             .joint = Prismatic{.axis = x_axis, .effort = -H}});
  const Instant at(model);
  for (int k = 0; k < n; ++k) {
    CHECK(std::abs(at.workspace.a[static_cast<std::size_t>(k)]) < 1e-9);  // rad/s²; 100 m/s² would be that of a released joint
    check_near(at.force(k), {-H, (n - k) * m * g, 0}, 1e-12, "joint " + std::to_string(k));
  }
  check_near(at.force(n), {-H, 0, 0}, 1e-12, "the drive");
}

TEST_CASE("(32) (47) accelerations and reactions along the reference trajectories") {
  for (const char* file : {"spatial_chain.json", "heavy_top.json"}) {
    CAPTURE(file);
    const auto data = reference(file);
    Model model({.gravity = vec3_of(data["model"]["gravity"])});
    for (const auto& b : data["model"]["bodies"]) {
      BodySpec body{.name = b["name"], .mass = b["mass"], .com = vec3_of(b["com"])};
      const auto& i = b["inertia"];
      body.inertia = {i[0][0], i[1][1], i[2][2], i[0][1], i[0][2], i[1][2]};
      if (!b["parent"].is_null()) body.parent = model.body(b["parent"].get<std::string>());
      body.at = {vec3_of(b["Xtree"]["pos"]), quat_of(b["Xtree"]["quat"])};
      body.joint.kind = find_kind(b["joint"]["kind"].get<std::string>())->kind;
      if (b["joint"].contains("axis")) body.joint.axis = vec3_of(b["joint"]["axis"]);
      if (b["joint"].contains("axis2")) body.joint.axis2 = vec3_of(b["joint"]["axis2"]);
      body.joint.parameters.damping = b["joint"]["damping"].get<double>();
      model.add(body);
    }
    for (const auto& row : data["samples"]) {
      const auto& joints = row["trees"][0];
      const Instant at(with_start(model, joints));
      for (int b = 0; b < model.size(); ++b) {
        const auto& joint = joints[model[{b}].name];
        CAPTURE(model[{b}].name);
        for (std::size_t i = 0; i < joint["udot"].size(); ++i) {
          const double expected = joint["udot"][i];
          check_near(at.workspace.a[static_cast<std::size_t>(at.tree.first_p(b)) + i], expected, 1e-10 * (1 + std::abs(expected)),
                     "a");
        }
        const auto& w = joint["reaction"];
        const Force<double> W = at.reaction(b);
        const double scale = 1 + norm(W.l) + norm(W.h);
        check_near(W.l, {w[0], w[1], w[2]}, 1e-10 * scale, "force");
        check_near(W.h, {w[3], w[4], w[5]}, 1e-10 * scale, "torque");
      }
    }
  }
}
