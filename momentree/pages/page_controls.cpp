#include <momentree/pages/page_controls.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include <momentree/scenario/part_reader.hpp>
#include <momentree/simulate/events/topology_record.hpp>

namespace momentree::io {

std::vector<Action> scaled_damping(const World& world, double factor, double offset) {
  std::vector<Action> actions;
  for (int j = 0; j < world.model().size(); ++j) {
    if (world.tree().carrier(j) < 0) continue;
    const JointView joint = world.joint({j});
    const JointSpec& declared = world.model()[{j}].joint;
    const KindInfo& kind = info(joint.kind);
    if (joint.kind != declared.kind || joint.kind == Kind::free || kind.nv == 0 || joint.driven) continue;
    JointParameters all;
    for (int i = 0; i < kind.nv; ++i)
      all.damping.push_back(factor * declared.parameters.damping.of(i) + (kind.v_units[i] == 'r' ? offset : 0));
    actions.push_back(set_parameters(std::string(joint.name), all));
  }
  return actions;
}

std::vector<Action> limited_strength(const World& world, double force) {
  std::vector<Action> actions;
  for (const JointId number : present_joints(world)) {
    const JointView joint = world.joint(number);
    if (joint.kind == Kind::free) continue;
    JointParameters strength;
    strength.strength.force = force;
    if (!is_loop(number) && number.index < world.model().size()) {
      const JointStrength& declared = world.model()[BodyId{number.index}].joint.parameters.strength;
      strength.strength = {std::min(force, declared.force), declared.torque};
    }
    actions.push_back(set_parameters(std::string(joint.name), strength));
  }
  return actions;
}

Wrench PageControls::force_of(const Grip& grip, const EvaluationContext& context) {
  const BodyMotion motion = context.motion({grip.body});
  const Vec3 arm = rotation_matrix(motion.pose.rotation) * grip.point;
  const Vec3 speed = motion.linear + cross(motion.angular, arm);
  const Vec3 force = grip.stiffness * (grip.target - (motion.pose.position + arm)) - grip.damping * speed;
  return {force, cross(arm, force)};
}

bool PageControls::obey(Message& message) {
  static constexpr MessageHandler<PageControls> handlers[] = {
      {"act",
       [](PageControls& to, Message& m) {
         std::string problem;
         const std::vector<Action> actions = actions_now(m.any("action"), to.simulation_.world(), problem);
         m.refuse(problem);
         to.apply(actions, m);
       }},
      {"gravity",
       [](PageControls& to, Message& m) {
         if (const Vec3 value = m.vector("value"); m.ok()) to.simulation_.set_gravity(value);
       }},
      {"damping",
       [](PageControls& to, Message& m) {
         to.apply(scaled_damping(to.simulation_.world(), m.number("factor"), m.number("offset")), m);
       }},
      {"strength",
       [](PageControls& to, Message& m) { to.apply(limited_strength(to.simulation_.world(), m.number("force")), m); }},
      {"grab", [](PageControls& to, Message& m) { to.grab(m); }},
      {"pull", [](PageControls& to, Message& m) { to.pull(m); }},
      {"release", [](PageControls& to, Message&) { to.release(); }}};
  return carry_out(message, *this, handlers);
}

void PageControls::apply(const std::vector<Action>& actions, Message& message) {
  if (!message.ok() || actions.empty()) return;
  const RunResult result = simulation_.try_apply(actions);
  if (result == Status::refused) message.refuse(result.reason);
}

std::shared_ptr<const BodyFunction> PageControls::function_on(int body) const {
  for (const Topology::Loaded& each : simulation_.world().tree().loads().functions)
    if (each.body == body) return each.function;
  return nullptr;
}

bool PageControls::holds() const {
  return grip_.body >= 0 && simulation_.world().alive({grip_.body}) && function_on(grip_.body) == grip_.function;
}

void PageControls::apply_grip() {
  Grip grip = grip_;
  grip.function = nullptr;
  simulation_.force(simulation_.world().model()[{grip.body}].name,
                    [grip](const EvaluationContext& context) { return force_of(grip, context); });
  grip_.function = function_on(grip.body);
}

void PageControls::grab(Message& message) {
  release();
  const World& world = simulation_.world();
  const std::string name = message.text("body");
  const Vec3 point = message.vector("point");
  const double strength = message.number("strength", 1);
  const int body = world.model().has_body(name) ? world.model().body(name).index : -1;
  if (!world.alive({body})) return message.refuse("there is no body '" + name + "'");
  const Vec3 target = message.vector("target", world.motions()[static_cast<std::size_t>(body)].pose * point);
  if (function_on(body) != nullptr) message.refuse("the program applies a force to this body, which a grip would replace");
  if (!message.ok()) return;
  double whole = 0;
  for (const Mechanism& mechanism : world.mechanisms()) {
    if (std::find(mechanism.bodies.begin(), mechanism.bodies.end(), BodyId{body}) == mechanism.bodies.end()) continue;
    for (const BodyId each : mechanism.bodies) whole += world.model()[each].mass;
  }
  // The spring oscillates the whole mechanism at three hertz; the damper is chosen for the body alone, so that a step can resolve
  // it.
  constexpr double swing = 2 * 3.14159265358979 * 3;
  const double mass = world.model()[{body}].mass;
  const double stiffness = strength * whole * swing * swing;
  grip_ = {body, point, target, stiffness, 2 * std::sqrt(stiffness * (mass > 0 ? mass : whole))};
  apply_grip();
}

void PageControls::pull(Message& message) {
  const Vec3 target = message.vector("target");
  if (!message.ok() || grip_.body < 0) return;
  if (!holds()) {
    forget();
    return message.refuse("the program now applies a force to this body, which has replaced the grip");
  }
  grip_.target = target;
  apply_grip();
}

void PageControls::release() {
  if (holds()) simulation_.force(simulation_.world().model()[{grip_.body}].name, {});
  forget();
}

}  // namespace momentree::io
