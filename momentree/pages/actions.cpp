// What a reader of a page does to a running world.
#include <algorithm>
#include <cmath>

#include <momentree/pages/page_world.hpp>
#include <momentree/simulate/events/topology_record.hpp>

namespace momentree::io {

std::optional<std::string> joint_name(const World& world, int joint) {
  const bool exists = is_loop({joint}) ? world.tree().loops().find({joint}) != nullptr
                                       : joint >= 0 && joint < world.model().size() && world.tree().carrier(joint) >= 0;
  if (!exists) return std::nullopt;
  return std::string(world.joint_name({joint}));
}

std::optional<std::string> body_name(const World& world, int body, bool ground_too) {
  if (ground_too && body == -1) return "ground";
  if (!world.alive({body})) return std::nullopt;
  return world.model()[{body}].name;
}

Grip grip_on(const World& world, int body, Vec3 point, double strength) {
  double whole = 0;
  for (const Mechanism& mechanism : world.mechanisms()) {
    if (std::find(mechanism.bodies.begin(), mechanism.bodies.end(), BodyId{body}) == mechanism.bodies.end()) continue;
    for (const BodyId each : mechanism.bodies) whole += world.model()[each].mass;
  }
  // The spring oscillates the whole mechanism at three hertz; the damper is chosen for the body alone, so that a step can resolve
  // it.
  constexpr double swing = 2 * 3.14159265358979 * 3;
  const double mass = world.model()[{body}].mass;
  Grip grip{body, point, world.motions()[static_cast<std::size_t>(body)].pose * point, 0, 0};
  grip.stiffness = strength * whole * swing * swing;
  grip.damping = 2 * std::sqrt(grip.stiffness * (mass > 0 ? mass : whole));
  return grip;
}

Wrench pull(const Grip& grip, const EvaluationContext& context) {
  const BodyMotion motion = context.motion({grip.body});
  const Vec3 arm = rotation_matrix(motion.pose.rotation) * grip.point;
  const Vec3 speed = motion.linear + cross(motion.angular, arm);
  const Vec3 force = grip.stiffness * (grip.target - (motion.pose.position + arm)) - grip.damping * speed;
  return {force, cross(arm, force)};
}

std::vector<Action> scaled_damping(const World& world, const Model& model, double factor, double offset) {
  std::vector<Action> actions;
  for (int j = 0; j < model.size(); ++j) {
    if (world.tree().carrier(j) < 0) continue;
    const JointView joint = world.joint({j});
    const JointSpec& declared = model[{j}].joint;
    const KindInfo& kind = info(joint.kind);
    if (joint.kind != declared.kind || joint.kind == Kind::free || kind.nv == 0 || joint.driven) continue;
    JointParameters all;
    for (int i = 0; i < kind.nv; ++i)
      all.damping.push_back(factor * declared.parameters.damping.of(i) + (kind.v_units[i] == 'r' ? offset : 0));
    actions.push_back(set_parameters(std::string(joint.name), all));
  }
  return actions;
}

std::vector<Action> limited_strength(const World& world, const Model& model, double force) {
  std::vector<Action> actions;
  for (const JointId number : present_joints(world)) {
    const JointView joint = world.joint(number);
    if (joint.kind == Kind::free) continue;
    JointParameters strength;
    strength.strength.force = force;
    if (!is_loop(number) && number.index < model.size()) {
      const JointStrength& declared = model[BodyId{number.index}].joint.parameters.strength;
      strength.strength = {std::min(force, declared.force), declared.torque};
    }
    actions.push_back(set_parameters(std::string(joint.name), strength));
  }
  return actions;
}

}  // namespace momentree::io
