// Structure of a world, as JSON.
#include <algorithm>

#include <momentree/pages/message.hpp>
#include <momentree/pages/page_world.hpp>
#include <momentree/results/summary.hpp>
#include <momentree/scenario/state/joint_json.hpp>
#include <momentree/simulate/events/topology_record.hpp>

namespace momentree::io {

int row_of(const World& world, JointId joint) {
  return is_loop(joint) ? world.model().size() + joint.index - first_loop : joint.index;
}

int joint_row_count(const World& world) {
  int rows = world.model().size();
  for (const JointId loop : world.loops()) rows = std::max(rows, row_of(world, loop) + 1);
  return rows;
}

std::string scenario_json(const Scenario& scenario, const Vec3& gravity, bool floor) {
  std::string text;
  JsonWriter json(text);
  json.begin_object().member("title", scenario.title);
  json.member("until", scenario.until).member("every", scenario.output_every);
  json.member("step", scenario.integration.step).member("method", scenario.integration.method);
  json.member("gravity", gravity).member("floor", floor).key("events").begin_array();
  for (const ScenarioEvent& event : scenario.events) {
    json.begin_object().member("name", event.name).member("time", event.time).member("line", event.place.line);
    json.key("actions").begin_array();
    for (const Action& action : event.actions) json.value(action.text());
    json.end_array().end_object();
  }
  json.end_array().end_object();
  return text;
}

std::string loaded_json(std::string_view diagnostics, std::string_view scenario, std::string_view model,
                        std::string_view topology, std::string_view frame) {
  std::string text;
  JsonWriter json(text);
  json.begin_object().member("type", "loaded").key("diagnostics").raw(diagnostics).key("world");
  if (model.empty()) {
    json.null();
  } else {
    json.begin_object().key("scenario").raw(scenario).key("model").raw(model).key("topology").raw(topology);
    json.key("frame").raw(frame).key("kinds");
    write_kinds(json);
    json.end_object();
  }
  json.end_object();
  return text;
}

std::string event_list(const std::vector<Event>& events, std::size_t first) {
  std::string text;
  for (std::size_t i = first; i < events.size(); ++i) text += (i == first ? "" : ",") + event_json(events[i]);
  return text;
}

std::string topology_json(const World& world) {
  std::string text;
  JsonWriter json(text);
  json.begin_object().key("mechanisms").begin_array();
  for (const Mechanism& mechanism : world.mechanisms()) {
    json.begin_object().member("name", mechanism.name).member("root", mechanism.root.index);
    json.member("grounded", mechanism.grounded).key("bodies").begin_array();
    for (const BodyId body : mechanism.bodies) json.value(body.index);
    json.end_array().end_object();
  }
  json.end_array().key("joints").begin_array();
  for (const JointId number : present_joints(world)) {
    const JointView joint = world.joint(number);
    json.begin_object()
        .member("number", number.index)
        .member("row", row_of(world, number))
        .member("name", joint.name)
        .member("kind", info(joint.kind).name);
    json.member("parent", joint.parent.index).member("child", joint.child.index);
    json.member("locked", static_cast<int>(joint.locked));
    write_pose(json, "at", joint.at);
    write_pose(json, "child_at", joint.child_at);
    json.member("axis", joint.axis);
    const JointParameters none, &p = joint.parameters != nullptr ? *joint.parameters : none;
    json.member("damping", p.damping.of(0))
        .member("stiffness", p.stiffness.of(0))
        .member("force", p.strength.force)
        .member("torque", p.strength.torque);
    if (joint.loop) json.member("loop", true);
    json.end_object();
  }
  json.end_array();
  if (world.springs() > 0) {
    json.key("broken_springs").begin_array();
    for (int s = 0; s < world.springs(); ++s)
      if (const SpringView spring = world.spring({s}); spring.broken) json.value(spring.name);
    json.end_array();
  }
  if (world.couplings() > 0) {
    json.key("couplings").begin_array();
    for (int c = 0; c < world.couplings(); ++c) {
      const auto [joint, follows] = coupling_names(world, {c});
      json.begin_object().member("joint", joint).member("follows", follows);
      json.member("ended", world.coupling({c}).ended).end_object();
    }
    json.end_array();
  }
  json.end_object();
  return text;
}

void KnownWorld::read(const Simulation& simulation) {
  topology = topology_json(simulation.world());
  revision = simulation.world().tree().revision();
  events = simulation.events().size();
}

bool KnownWorld::tell(const Simulation& simulation, const std::function<void(const std::string&)>& post, std::string& lines) {
  bool news = false;
  if (const std::uint64_t now = simulation.world().tree().revision(); now != revision) {
    revision = now;
    std::string text = topology_json(simulation.world());
    if (text != topology) {  // the target of a grip is in none
      topology = std::move(text), text.clear();
      JsonWriter json(text);
      json.begin_object().member("type", "topology").member("time", simulation.time()).key("topology").raw(topology).end_object();
      post(text);
      news = true;
    }
  }
  if (simulation.events().size() > events) {
    lines = event_list(simulation.events(), events);
    post(message_json("events", "events", "[" + lines + "]"));
    news = true;
  }
  events = simulation.events().size();
  return news;
}

}  // namespace momentree::io
