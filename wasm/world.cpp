// Worlds made from scenarios, and the changes to them.
#include <wasm/world.hpp>

#include <momentree/scenario/events/schedule.hpp>

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

}  // namespace momentree::wasm

using namespace momentree;

int MtWorld::act(const std::vector<Action>& actions) {
  changed();
  const Status status = simulation->try_apply(actions);
  if (status == Status::refused) text = simulation->result().reason;
  return status == Status::refused ? mt_refused : mt_ok;
}

std::optional<std::string> MtWorld::joint_name(int joint) {
  std::optional<std::string> name = io::joint_name(simulation->world(), joint);
  if (!name) text = "joint number " + std::to_string(joint) + " no longer exists";
  return name;
}

std::optional<std::string> MtWorld::body_name(int body, bool ground_too) {
  std::optional<std::string> name = io::body_name(simulation->world(), body, ground_too);
  if (!name) text = "body number " + std::to_string(body) + " no longer exists";
  return name;
}

void MtWorld::apply_grip(int body) {
  const std::string& name = simulation->world().model()[{body}].name;
  if (grip.body < 0) return simulation->force(name, {});
  simulation->force(name, [grip = grip](const EvaluationContext& context) { return io::pull(grip, context); });
}

void MtWorld::after_restore() {
  std::vector<std::string> pulled;
  for (const Topology::Loaded& load : simulation->world().tree().loads().functions)
    pulled.push_back(simulation->world().model()[{load.body}].name);
  for (const std::string& body : pulled) simulation->force(body, {});
  grip = {};
  events_seen = simulation->events().size();
  changed();
}
