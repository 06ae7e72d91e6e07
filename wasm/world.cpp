// Worlds made from scenarios, and the changes to them.
#include <wasm/world.hpp>

#include <algorithm>

#include <momentree/io/schedule.hpp>

namespace momentree::wasm {

std::unique_ptr<Simulation> start(const io::Scenario& scenario) {
  auto simulation = std::make_unique<Simulation>(scenario.model, scenario.integration);
  io::couple(*simulation, scenario.couplings);
  std::vector<const io::ScenarioEvent*> events;
  for (const io::ScenarioEvent& event : scenario.events) events.push_back(&event);
  io::schedule(*simulation, std::move(events));  // the reader has found no problems with them
  simulation->keep_history();
  return simulation;
}

int row_of(const World& world, JointId joint) {
  return is_loop(joint) ? world.model().size() + joint.index - first_loop : joint.index;
}

int joint_rows(const World& world) {
  int rows = world.model().size();
  for (const JointId loop : world.loops()) rows = std::max(rows, row_of(world, loop) + 1);
  return rows;
}

std::vector<Threshold> thresholds_of(const io::Scenario& scenario, const World& world) {
  std::vector<Threshold> all;
  for (const io::ScenarioEvent& event : scenario.events) {
    if (!event.condition || !event.condition->what->is_load() || event.condition->threshold == 0) continue;
    for (const std::string& joint : event.condition->what->joints())
      if (const int number = world.find_joint(joint); number >= 0) all.push_back({number, *event.condition});
  }
  return all;
}

}  // namespace momentree::wasm

using namespace momentree;

int MtWorld::act(const std::vector<Action>& actions) {
  changed();
  const Status status = simulation->try_apply(actions);
  if (status == Status::refused) text = simulation->result().reason;
  return status == Status::refused ? mt_refused : mt_ok;
}

std::optional<std::string> MtWorld::joint_name(int joint) {
  const World& world = simulation->world();
  const bool exists = is_loop({joint}) ? world.tree().find_loop({joint}) != nullptr
                                       : joint >= 0 && joint < world.model().size() && world.tree().carrier(joint) >= 0;
  if (exists) return std::string(world.joint_name({joint}));
  text = "joint number " + std::to_string(joint) + " no longer exists";
  return std::nullopt;
}

std::optional<std::string> MtWorld::body_name(int body, bool ground_too) {
  if (ground_too && body == -1) return "ground";
  if (simulation->world().alive({body})) return simulation->world().model()[{body}].name;
  text = "body number " + std::to_string(body) + " no longer exists";
  return std::nullopt;
}

void MtWorld::apply_grip(int body) {
  const std::string& name = simulation->world().model()[{body}].name;
  if (grip.body < 0) return simulation->force(name, {});
  simulation->force(name, [grip = grip](const EvaluationContext& context) {
    const BodyMotion motion = context.motion({grip.body});
    const Vec3 arm = rotation_matrix(motion.pose.rotation) * grip.point;
    const Vec3 speed = motion.linear + cross(motion.angular, arm);
    const Vec3 force = grip.stiffness * (grip.target - (motion.pose.position + arm)) - grip.damping * speed;
    return Wrench{force, cross(arm, force)};
  });
}

void MtWorld::after_restore() {
  std::vector<std::string> pulled;
  for (const Topology::Loaded& load : simulation->world().tree().body_functions())
    pulled.push_back(simulation->world().model()[{load.body}].name);
  for (const std::string& body : pulled) simulation->force(body, {});
  grip = {};
  events_seen = simulation->events().size();
  changed();
}
