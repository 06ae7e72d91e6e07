#include <momentree/results/summary.hpp>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/state/joint_json.hpp>

#ifndef MOMENTREE_VERSION
#error "MOMENTREE_VERSION is set by the build"
#endif

namespace momentree::io {

namespace {

void write_totals(JsonWriter& json, const Totals& totals) {
  json.begin_object();
  json.member("kinetic", totals.kinetic).member("potential", totals.potential);
  json.member("linear", totals.linear).member("angular", totals.angular);
  if (totals.loops.rows > 0) write_loops(json, totals.loops);
  json.end_object();
}

void write_split(JsonWriter& json, const char* name, double before, double after) {
  json.key(name).begin_object().member("before", before).member("after", after).end_object();
}

void write_origin(JsonWriter& json, const RunOrigin& origin, const std::string& status) {
  json.member("status", status).member("version", MOMENTREE_VERSION);
  json.key("scenario").begin_object();
  json.member("name", origin.name).member("title", origin.title).member("file", origin.file).member("hash", origin.hash);
  json.key("overrides").begin_array();
  for (const std::string& set : origin.overrides) json.value(set);
  json.end_array().end_object();
  json.member("method", origin.integration.method);
  json.member("variables", name_of(origin.integration.state_variables())).member("step", origin.integration.step);
  if (is_adaptive(origin.integration.method)) {  // no bound: null
    json.member("rtol", origin.integration.rtol).member("atol", origin.integration.atol);
    json.member("max_step", origin.integration.max_step);
  } else if (std::isfinite(origin.integration.max_step) && steps_through_contacts(origin.integration.method)) {
    json.member("max_step", origin.integration.max_step);
  }
  if (origin.reactions) json.member("reactions", true);
}

// For readers that do not parse the texts of actions.
void write_changes(JsonWriter& json, const std::vector<ActionRecord>& actions) {
  json.key("changes").begin_array();
  for (const ActionRecord& action : actions) {
    json.begin_object().member("kind", action.kind);
    if (!action.joint.empty()) json.member("joint", action.joint);
    if (!action.spring.empty()) json.member("spring", action.spring);
    if (!action.body.empty()) json.member("body", action.body);
    if (!action.to.empty()) json.member("to", action.to);
    if (!action.skipped.empty()) json.member("skipped", action.skipped);
    json.end_object();
  }
  json.end_array();
}

void write_topology(JsonWriter& json, const TopologyRecord& topology) {
  json.key("topology").begin_object();
  json.key("gone").begin_array();
  for (const std::string& joint : topology.gone) json.value(joint);
  json.end_array().key("joints").begin_object();
  for (const JointRecord& joint : topology.joints) {
    json.key(joint.name).begin_object();
    write_joint_frame(json, joint);
    write_locked(json, joint.locked, info(joint.kind).nv);
    json.end_object();
  }
  json.end_object().key("moved").begin_object();
  for (const TopologyRecord::Moved& moved : topology.moved) {
    json.key(moved.mechanism).begin_array();
    for (const auto& [first, count] : moved.bodies) json.begin_array().value(first).value(count).end_array();
    json.end_array();
  }
  json.end_object();
  if (!topology.broken_springs.empty()) {
    json.key("broken_springs").begin_array();
    for (const std::string& spring : topology.broken_springs) json.value(spring);
    json.end_array();
  }
  if (!topology.ended_couplings.empty()) {
    json.key("ended_couplings").begin_array();
    for (const auto& [joint, follows] : topology.ended_couplings) {
      json.begin_object().member("joint", joint);
      if (!follows.empty()) json.member("follows", follows);
      json.end_object();
    }
    json.end_array();
  }
  json.end_object();
}

}  // namespace

std::vector<MissedEvent> missed_events(const Simulation& simulation) {
  std::unordered_set<std::string> happened;
  for (const Event& event : simulation.events()) happened.insert(event.name);
  std::vector<MissedEvent> all;
  std::unordered_map<std::string, std::size_t> places;
  for (MissedEvent& missed : simulation.missed()) {
    if (happened.contains(missed.name)) continue;
    const auto [place, fresh] = places.emplace(missed.name, all.size());
    if (fresh) {
      all.push_back(std::move(missed));
      continue;
    }
    MissedEvent& known = all[place->second];
    const bool nearer = missed.exceeds ? missed.nearest > known.nearest : missed.nearest < known.nearest;
    if (std::isnan(known.nearest) || nearer) known = std::move(missed);
  }
  return all;
}

std::string event_json(const Event& event) {
  std::string text;
  JsonWriter json(text);
  json.begin_object();
  json.member("time", event.time).member("event", event.name);
  json.key("actions").begin_array();
  for (const ActionRecord& action : event.actions) json.value(action.text());
  json.end_array();
  json.key("mechanisms").begin_object();
  json.key("before").begin_array();
  for (const std::string& name : event.mechanisms_before) json.value(name);
  json.end_array().key("after").begin_array();
  for (const std::string& name : event.mechanisms_after) json.value(name);
  json.end_array().end_object();
  write_changes(json, event.actions);
  if (!event.topology.empty()) write_topology(json, event.topology);
  json.key("before");
  write_totals(json, event.before);
  json.key("after");
  write_totals(json, event.after);
  json.member("released", event.released).member("lost", event.lost).member("work", event.work);
  const Event::Contact& contact = event.contact;
  const bool at_contact = !contact.one.empty();
  if (at_contact) {
    const auto vector = [&](const char* key, const Vec3& v) {
      const double numbers[3] = {v.x, v.y, v.z};
      json.member(key, std::span<const double>(numbers));
    };
    json.key("bodies").begin_array().value(contact.one).value(contact.other).end_array();
    vector("point", contact.point), vector("normal", contact.normal), vector("impulse", contact.impulse);
    if (!contact.cable.empty()) json.member("cable", contact.cable);
    if (contact.scaled < 1) json.member("scaled", contact.scaled);
    if (contact.in_turn) json.member("in_turn", true);
  }
  if (!event.reason.empty()) json.member("reason", event.reason);
  if (!event.stepped.empty()) {
    json.key("stepped").begin_array();
    for (const std::string& name : event.stepped) json.value(name);
    json.end_array();
  }
  json.key(at_contact ? "joint_impulse" : "impulse").begin_object();
  for (const auto& [joint, impulse] : event.impulse) json.member(joint, std::span<const double>(impulse));
  json.end_object();
  if (!event.coupling_impulse.empty()) {
    json.key("coupling_impulse").begin_array();
    for (const Event::OfCoupling& each : event.coupling_impulse) {
      json.begin_object().member("joint", each.joint);
      if (!each.follows.empty()) json.member("follows", each.follows);
      json.member("on_joint", each.on_joint);
      if (!each.follows.empty()) json.member("on_follows", each.on_follows);
      json.end_object();
    }
    json.end_array();
  }
  json.member("ground_impulse", std::span<const double>(event.ground_impulse));
  json.key("hardest");
  if (event.hardest_joint.empty()) {
    json.null();
  } else {
    json.begin_object().member("joint", event.hardest_joint);
    json.member("linear", event.hardest_linear).member("angular", event.hardest_angular).end_object();
  }
  json.member("duration_ns", event.duration_ns);
  json.end_object();
  return text;
}

namespace {

void write_missed(JsonWriter& json, const Simulation& simulation) {
  json.key("missed").begin_array();
  for (const MissedEvent& missed : missed_events(simulation)) {
    json.begin_object().member("event", missed.name);
    if (!missed.quantity.empty()) {
      json.key("of").begin_array();
      for (const std::string& name : missed.of) json.value(name);
      json.end_array();
      json.member("quantity", missed.quantity).member(missed.exceeds ? "exceeds" : "below", missed.threshold);
      json.member("nearest", missed.nearest).member("nearest_time", missed.nearest_time);  // null if the quantity never existed
      if (missed.lasts > 0) json.member("for", missed.lasts).member("held", missed.held);
    } else if (!missed.after.empty() && !std::isfinite(missed.time)) {
      json.member("after", missed.after);
    } else {
      json.member("time", missed.time);
    }
    json.end_object();
  }
  json.end_array();
}

std::span<const Event> events_of(const RunOrigin& origin, const Simulation& simulation) {
  const std::span<const Event> all = simulation.events();
  return all.subspan(std::min(origin.first_event, all.size()));
}

}  // namespace

RunOrigin run_origin(const Scenario& scenario, const Simulation& simulation, double until) {
  RunOrigin origin{scenario.name,     scenario.title, scenario.path,       scenario.hash, {},
                   simulation.time(), until,          scenario.integration};
  origin.first_event = simulation.events().size();
  origin.integration.variables = simulation.world().state().variables();
  return origin;
}

std::vector<std::string> run_warnings(const RunOrigin& origin, const Simulation& simulation) {
  struct Idle {
    std::string event, first;
    long count = 0;
  };
  std::vector<Idle> all;
  std::unordered_map<std::string, std::size_t> places;
  for (const Event& event : events_of(origin, simulation))
    for (const ActionRecord& action : event.actions) {
      if (action.skipped.empty()) continue;
      const auto [place, fresh] = places.emplace(event.name, all.size());
      if (fresh) all.push_back({event.name, action.kind + " " + action.target + " did nothing: " + action.skipped});
      ++all[place->second].count;
    }
  std::vector<std::string> warnings;
  for (const Idle& idle : all)
    warnings.push_back(
        "event '" + idle.event + "': " + idle.first +
        (idle.count > 1 ? "; it is the first of " + std::to_string(idle.count) + " such actions of the event" : ""));
  if (simulation.result().reason.empty())  // the last energies of a diverged run are meaningless
    for (std::string& warning : simulation.warnings()) warnings.push_back(std::move(warning));
  return warnings;
}

std::string summary_json(const RunOrigin& origin, const std::string& status) {
  std::string text;
  JsonWriter json(text, 2);
  json.begin_object();
  write_origin(json, origin, status);
  json.member("start", origin.start).member("until", origin.until).end_object();
  return text + '\n';
}

std::string summary_json(const RunOrigin& origin, const std::string& status, const Simulation& simulation) {
  const RunStatistics& run = simulation.statistics();
  const EnergyBalance energy = simulation.energy();
  const double wall = run.total_seconds[0] + run.total_seconds[1];

  std::string text;
  JsonWriter json(text, 2);
  json.begin_object();
  write_origin(json, origin, status);
  json.member("start", origin.start).member("until", origin.until).member("time", simulation.time());
  json.member("steps", run.steps).member("evaluations", run.evaluations[0] + run.evaluations[1]);
  json.member("topology_changes", run.changes).member("events", static_cast<long>(events_of(origin, simulation).size()));
  json.key("wall_clock").begin_object();
  write_split(json, "evaluations", run.evaluation_seconds[0], run.evaluation_seconds[1]);
  write_split(json, "topology", 0, run.topology_seconds);  // part of the total after the first change
  write_split(json, "total", run.total_seconds[0], run.total_seconds[1]);
  json.end_object();
  json.key("real_time_factor");
  if (wall > 0)
    json.value((simulation.time() - origin.start) / wall);
  else
    json.null();
  json.member("worst_step", run.worst_step_seconds);
  if (run.contact_residual > 0) json.member("contact_residual", run.contact_residual);
  json.key("energy").begin_object();
  json.member("initial", energy.initial).member("final", energy.final);
  json.member("dissipated", energy.dissipated).member("work", energy.work);
  json.member("lost_in_impacts", energy.lost_in_impacts).member("released", energy.released);
  if (simulation.world().tree().has_loops() || energy.projection != 0) json.member("projection", energy.projection);
  json.member("error", energy.error).member("largest_kinetic", energy.largest_kinetic);
  json.end_object();
  write_missed(json, simulation);
  json.key("warnings").begin_array();
  for (const std::string& warning : run_warnings(origin, simulation)) json.value(warning);
  json.end_array().end_object();
  text += '\n';
  return text;
}

}  // namespace momentree::io
