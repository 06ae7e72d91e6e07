// Writes the state document.
#include <algorithm>
#include <cmath>
#include <string_view>

#include <momentree/scenario/keys/described.hpp>
#include <momentree/scenario/state/joint_json.hpp>
#include <momentree/scenario/state/parameters_json.hpp>
#include <momentree/scenario/state/state_contact.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <momentree/simulate/events/topology_record.hpp>

namespace momentree::io {

namespace {

void write_coordinates(JsonWriter& json, const JointView& joint) {
  double q[Values::capacity];
  std::copy(joint.q.begin(), joint.q.end(), q);
  const std::size_t w = std::string_view(info(joint.kind).q_units).find('n');
  if (w != std::string_view::npos) {
    const double sign = q[w] < 0 ? -1 : 1;
    for (std::size_t i = w; i < w + 4; ++i) q[i] = q[i] == 0 ? 0 : sign * q[i];  // no minus zero, whose sign would not be known
  }
  json.member("q", std::span<const double>(q, joint.q.size()));
}

// Per DoF: 1 on its upper stop, -1 on its lower stop, 0 on none; and the force of a stop that is stepped through.
void write_resting(JsonWriter& json, const World& world, int number, const JointView& joint, const StepMemory& memory) {
  std::vector<double> sides(static_cast<std::size_t>(info(joint.kind).nv), 0.0), forces = sides;
  for (const ActiveLimit& hold : world.constraints().active_limits)
    if (hold.joint == number) sides[static_cast<std::size_t>(hold.dof)] = hold.sign;
  bool stepped = false;
  for (const SteppedContact& stop : memory.stepping.points) {
    if (stop.joint != number) continue;
    stepped = true, forces[stop.id] = -stop.side * stop.force.x;
    if (stop.rests) sides[stop.id] = stop.side;
  }
  if (std::ranges::any_of(sides, [](double side) { return side != 0; })) json.member("resting", std::span<const double>(sides));
  if (stepped) json.member("stop_forces", std::span<const double>(forces));
}

// Per DoF where its lower and its upper stop act, if that is beyond their limits.
void write_deeper(JsonWriter& json, const StepMemory& memory, const JointView& joint) {
  const auto belongs = [&](const auto& each) { return each.first == joint.name; };
  if (std::ranges::none_of(memory.deeper, belongs)) return;
  json.key("deeper").begin_array();
  for (int i = 0; i < info(joint.kind).nv; ++i) {
    double at[2] = {NAN, NAN};
    for (const auto& each : memory.deeper)
      if (belongs(each) && each.second.dof == i) at[each.second.sign > 0 ? 1 : 0] = each.second.sign * each.second.edge;
    json.value(std::span<const double>(at));
  }
  json.end_array();
}

void write_joint(JsonWriter& json, const World& world, int number, const StepMemory& memory) {
  const JointView joint = world.joint({number});
  json.key(joint.name).begin_object();
  write_joint_frame(json, joint_record(world, {number}));
  write_locked(json, joint.locked, info(joint.kind).nv);
  json.member("reversed", joint.reversed);
  if (!is_loop({number}) && is_detached(world.tree(), world.tree().carrier(number))) json.member("made", true);
  write_resting(json, world, number, joint, memory);
  write_deeper(json, memory, joint);
  json.key("parameters");
  write_parameters(json, joint.parameters != nullptr ? *joint.parameters : JointParameters{});
  write_coordinates(json, joint);
  json.member("v", joint.v).member("p", joint.p).member("pdot", joint.pdot);
  const JointForces forces = world.joint_forces({number});
  json.member("a", forces.a).key("reaction").begin_object();
  const auto& [force, torque] = forces.reaction;  // documents: about the origin of the child's frame
  json.member("force", force).member("torque", torque + cross(joint.child_at.position, force));
  if (world.tree().has_loops() || !world.tree().contacts().empty()) json.member("determined", forces.determined);
  json.end_object().end_object();
}

void write_body(JsonWriter& json, const std::string& name, const BodyMotion& motion, const BodyAcceleration& acceleration) {
  json.key(name).begin_object();
  json.member("position", motion.pose.position).member("quaternion", motion.pose.rotation);
  json.member("linear", motion.linear).member("angular", motion.angular);
  json.member("linear_acceleration", acceleration.linear).member("angular_acceleration", acceleration.angular);
  json.end_object();
}

void write_spring(JsonWriter& json, const World& world, int number) {
  const SpringView spring = world.spring({number});
  json.key(spring.name).begin_object();
  json.member("broken", spring.broken);
  MemberWriter members(json, world.model());
  if (spring.inextensible)  // the rest of a law is not for cables
    json.member("rest", spring.law.rest).member("strength", spring.law.strength);
  else
    describe(members, spring.law);
  json.member("length", spring.length).member("rate", spring.rate).member("tension", spring.tension);
  json.end_object();
}

// The state of a condition; values as at the start are omitted.
void write_condition(JsonWriter& json, const EventStatus& armed) {
  if (armed.done) json.member("done", true);
  if (std::isfinite(armed.time)) json.member("due", armed.time);
  if (armed.since >= 0) json.member("since", armed.since);
  if (armed.resting) json.member("resting", true);
  if (armed.looked < 0) return;
  json.key("looked").begin_array();
  if (armed.looked_before >= 0) json.begin_array().value(armed.looked_before).value(armed.excess_before).end_array();
  json.begin_array().value(armed.looked).value(armed.excess).end_array().end_array();
}

void write_armed(JsonWriter& json, const ArmedEvent& event) {
  json.key(event.name).begin_object().member("fired", event.fired);
  if (event.each.size() == 1) write_condition(json, event.each.front());
  if (event.each.size() > 1) {
    json.key("each").begin_array();
    for (const EventStatus& armed : event.each) {
      json.begin_object().member("fired", armed.fired);
      write_condition(json, armed);
      json.end_object();
    }
    json.end_array();
  }
  json.end_object();
}

void write_coupling(JsonWriter& json, const World& world, CouplingId number) {
  const CouplingView coupling = world.coupling(number);
  const auto [joint, follows] = coupling_names(world, number);
  json.begin_object().member("joint", joint);
  if (!follows.empty()) json.member("follows", follows);
  json.member("ended", coupling.ended);
  if (!coupling.ended) json.member("effort", coupling.effort).member("determined", coupling.determined);
  json.end_object();
}

}  // namespace

std::string state_json(const World& world, const Armed& armed, const StepMemory& memory) {
  const Model& model = world.model();
  std::string text;
  text.reserve(1000 * model.bodies().size() + 500);
  JsonWriter json(text, 2);
  json.begin_object().member("time", world.time());
  if (!(model.gravity() == world.start().gravity)) json.member("gravity", model.gravity());

  json.key("mechanisms").begin_array();
  for (const Mechanism& mechanism : world.mechanisms()) {
    json.begin_object().member("name", mechanism.name).member("root", model[mechanism.root].name);
    json.key("bodies").begin_array();
    for (const BodyId body : mechanism.bodies) json.value(model[body].name);
    json.end_array().end_object();
  }
  json.end_array();

  json.key("joints").begin_object();
  for (int j = 0; j < model.size(); ++j)
    if (world.tree().carrier(j) >= 0) write_joint(json, world, j, memory);
  for (const JointId loop : world.loops()) write_joint(json, world, loop.index, memory);
  json.end_object();

  if (world.springs() > 0) {
    json.key("springs").begin_object();
    for (int s = 0; s < world.springs(); ++s) write_spring(json, world, s);
    json.end_object();
  }

  if (world.couplings() > 0) {
    json.key("couplings").begin_array();
    for (int c = 0; c < world.couplings(); ++c) write_coupling(json, world, {c});
    json.end_array();
  }

  if (model.has_contact()) write_contacts(json.key("contacts"), world, memory.stepping);

  const std::vector<BodyMotion>& motions = world.motions();
  const std::vector<BodyAcceleration>& accelerations = world.accelerations();
  json.key("bodies").begin_object();
  for (std::size_t b = 0; b < motions.size(); ++b)
    if (world.alive({static_cast<int>(b)})) write_body(json, model.bodies()[b].name, motions[b], accelerations[b]);
  json.end_object();

  if (world.tree().has_loops()) write_loops(json, world.loop_status());

  json.key("armed").begin_object();
  for (const ArmedEvent& event : armed) write_armed(json, event);
  json.end_object();
  SteppingState without_points = memory.stepping;
  without_points.points.clear();
  const bool steps_matter = without_points != SteppingState{};
  if (memory.next_step > 0 || steps_matter) {
    json.key("integration").begin_object();
    if (memory.next_step > 0) json.member("step", memory.next_step).member("work", memory.work);
    if (steps_matter) write_stepping(json.key("contacts"), world, without_points);
    json.end_object();
  }

  const Totals totals = world.totals();
  json.key("totals").begin_object();
  json.member("kinetic", totals.kinetic).member("potential", totals.potential);
  json.member("linear", totals.linear).member("angular", totals.angular);
  json.end_object().end_object();
  text += '\n';
  return text;
}

}  // namespace momentree::io
