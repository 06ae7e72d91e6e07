// Implements engine.h.
#include <wasm/engine.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include <momentree/pages/floor.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/scenario/state/joint_json.hpp>
#include <wasm/world.hpp>

using namespace momentree;

#define EXPORT(name) __attribute__((export_name(#name)))

namespace {

using Clock = std::chrono::steady_clock;

int status_of(MtWorld& world, Status status) {
  switch (status) {
    case Status::ok: return mt_ok;
    case Status::interrupted: return mt_interrupted;
    case Status::stalled:
    case Status::diverged: world.text = world.simulation->result().reason; return mt_diverged;
    default: world.text = world.simulation->result().reason; return mt_refused;
  }
}

// Makes an action on the joint with that number.
template <class Make>
int act_on_joint(MtWorld& world, int joint, Make make) {
  const std::optional<std::string> name = world.joint_name(joint);
  return name ? world.act({make(*name)}) : mt_refused;
}

const KindInfo* kind_of(MtWorld& world, const char* kind, size_t length) {
  const std::string_view name(kind, length);
  const KindInfo* found = find_kind(name);
  if (found == nullptr) world.text = "there is no kind of joint '" + std::string(name) + "'";
  return found;
}

// A world has no access to files: a run cannot begin with a file that does not exist here.
std::string refusal_of(const io::Scenario& scenario) {
  return scenario.state_files.empty() ? "" : "state: files can't be read here; leave the state document out";
}

int load(MtWorld& world, std::string_view text, bool on_floor) {
  io::ReadResult result = io::read_scenario_text(text, "scenario.toml");
  const std::string refusal = result.scenario ? refusal_of(*result.scenario) : "";
  const bool sound = result.scenario && refusal.empty();
  const bool changed = sound && on_floor && io::put_on_floor(*result.scenario);
  world.text = wasm::load_json(result, refusal, changed);
  if (!sound) return 0;
  world.scenario = std::move(result.scenario);
  world.simulation = wasm::start(*world.scenario);
  world.thresholds = io::thresholds_of(*world.scenario, world.simulation->world());
  world.store = std::make_shared<wasm::Store>();
  world.grip = {};
  world.motions.clear(), world.posed.clear();
  world.events_seen = 0;
  world.changed();
  return 1;
}

}  // namespace

EXPORT(mt_allocate) void* mt_allocate(size_t bytes) { return std::malloc(bytes); }
EXPORT(mt_release) void mt_release(void* memory) { std::free(memory); }

EXPORT(mt_create) MtWorld* mt_create() { return new MtWorld; }
EXPORT(mt_destroy) void mt_destroy(MtWorld* world) { delete world; }

EXPORT(mt_load) int mt_load(MtWorld* world, const char* text, size_t length) { return load(*world, {text, length}, false); }
EXPORT(mt_load_on_floor) int mt_load_on_floor(MtWorld* world, const char* text, size_t length) {
  return load(*world, {text, length}, true);
}

EXPORT(mt_text) const char* mt_text(const MtWorld* world) { return world->text.data(); }
EXPORT(mt_text_length) size_t mt_text_length(const MtWorld* world) { return world->text.size(); }

EXPORT(mt_model) void mt_model(MtWorld* world) {
  const io::Scenario& scenario = *world->scenario;
  world->text = io::model_json(World(scenario.model), scenario.title, scenario.shapes);
}
EXPORT(mt_kinds) void mt_kinds(MtWorld* world) {
  world->text.clear();
  io::JsonWriter json(world->text);
  io::write_kinds(json);
}
EXPORT(mt_topology) void mt_topology(MtWorld* world) { world->text = io::topology_json(world->simulation->world()); }
EXPORT(mt_revision) int mt_revision(const MtWorld* world) { return world->revision; }

EXPORT(mt_run) int mt_run(MtWorld* world, double time, double budget) {
  Simulation& simulation = *world->simulation;
  if (!(time > simulation.time())) return mt_ok;
  const Clock::time_point end = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(budget));
  simulation.watch([end](double) { return Clock::now() < end; });
  Status status = simulation.run_until(time);
  if (status == Status::interrupted && simulation.time() >= time) status = Status::ok;
  if (simulation.events().size() != world->events_seen) world->changed();
  world->events_seen = simulation.events().size();
  return status_of(*world, status);
}
EXPORT(mt_time) double mt_time(const MtWorld* world) { return world->simulation->time(); }

EXPORT(mt_bodies) int mt_bodies(const MtWorld* world) { return world->simulation->world().model().size(); }
EXPORT(mt_motions) const double* mt_motions(MtWorld* world) {
  io::fill_motions(world->simulation->world(), world->motions);
  return world->motions.data();
}
EXPORT(mt_motions_at) const double* mt_motions_at(MtWorld* world, const double* q) {
  wasm::pose(world->scenario->model, q, world->motions, world->posed);
  return world->motions.data();
}
EXPORT(mt_posed) const double* mt_posed(const MtWorld* world) { return world->posed.data(); }
EXPORT(mt_joints) const double* mt_joints(MtWorld* world, int with_reactions) {
  io::fill_joints(*world->simulation, world->thresholds, with_reactions != 0, world->joints);
  return world->joints.data();
}
EXPORT(mt_joint_rows) int mt_joint_rows(const MtWorld* world) { return io::joint_row_count(world->simulation->world()); }
EXPORT(mt_totals) const double* mt_totals(MtWorld* world) {
  io::fill_totals(*world->simulation, world->totals);
  return world->totals;
}
EXPORT(mt_contacts) int mt_contacts(MtWorld* world) {
  world->contacts.clear();
  const std::vector<ContactPoint> points = world->simulation->world().contacts();
  for (const ContactPoint& point : points) {
    world->contacts.insert(world->contacts.end(), {double(point.one.index), double(point.other.index)});
    for (const Vec3* v : {&point.point, &point.normal, &point.force, &point.slip})
      world->contacts.insert(world->contacts.end(), {v->x, v->y, v->z});
    world->contacts.push_back(point.slips ? 1 : 0);
  }
  return static_cast<int>(points.size());
}
EXPORT(mt_contact_numbers) const double* mt_contact_numbers(const MtWorld* world) { return world->contacts.data(); }
EXPORT(mt_event_count) int mt_event_count(const MtWorld* world) { return static_cast<int>(world->simulation->events().size()); }
EXPORT(mt_events) void mt_events(MtWorld* world, int first) {
  world->text = "[" + io::event_list(world->simulation->events(), static_cast<size_t>(std::max(first, 0))) + "]";
}

EXPORT(mt_break) int mt_break(MtWorld* world, int joint) { return act_on_joint(*world, joint, break_joint); }
EXPORT(mt_free) int mt_free(MtWorld* world, int joint) { return act_on_joint(*world, joint, free_joint); }
EXPORT(mt_lock) int mt_lock(MtWorld* world, int joint) {
  return act_on_joint(*world, joint, [](const std::string& name) { return lock(name); });
}
EXPORT(mt_unlock) int mt_unlock(MtWorld* world, int joint) {
  return act_on_joint(*world, joint, [](const std::string& name) { return unlock(name); });
}
EXPORT(mt_weld) int mt_weld(MtWorld* world, int body, int to) {
  const auto one = world->body_name(body), other = world->body_name(to, true);
  return one && other ? world->act({weld(*one, *other)}) : mt_refused;
}
EXPORT(mt_attach) int mt_attach(MtWorld* world, int body, int to, const char* kind, size_t length, double x, double y, double z) {
  const KindInfo* info = kind_of(*world, kind, length);
  const auto one = world->body_name(body), other = world->body_name(to, true);
  if (info == nullptr || !one || !other) return mt_refused;
  JointSpec spec;
  spec.kind = info->kind;
  spec.axis = {x, y, z};
  if (info->axis2) spec.axis2 = std::fabs(x) > std::fabs(y) ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
  return world->act({attach(*one, *other, spec)});
}
EXPORT(mt_change) int mt_change(MtWorld* world, int joint, const char* kind, size_t length) {
  const KindInfo* info = kind_of(*world, kind, length);
  if (info == nullptr) return mt_refused;
  return act_on_joint(*world, joint, [info](const std::string& name) { return change_joint(name, info->kind); });
}
EXPORT(mt_impulse)
int mt_impulse(MtWorld* world, int body, double fx, double fy, double fz, double x, double y, double z) {
  const auto name = world->body_name(body);
  return name ? world->act({impulse(*name, {fx, fy, fz}, {}, {x, y, z})}) : mt_refused;
}

EXPORT(mt_set) int mt_set(MtWorld* world, int joint, double damping, double stiffness, double force, double torque) {
  JointParameters all;
  if (!std::isnan(damping)) all.damping = damping;
  if (!std::isnan(stiffness)) all.stiffness = stiffness;
  if (!std::isnan(force)) all.strength.force = force;
  if (!std::isnan(torque)) all.strength.torque = torque;
  return act_on_joint(*world, joint, [&all](const std::string& name) { return set_parameters(name, all); });
}

EXPORT(mt_set_damping) int mt_set_damping(MtWorld* world, double factor, double offset) {
  return world->act(io::scaled_damping(world->simulation->world(), world->scenario->model, factor, offset));
}

EXPORT(mt_limit_strength) int mt_limit_strength(MtWorld* world, double force) {
  return world->act(io::limited_strength(world->simulation->world(), world->scenario->model, force));
}

EXPORT(mt_set_gravity) int mt_set_gravity(MtWorld* world, double x, double y, double z) {
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) {
    world->text = "gravity must be finite numbers";
    return mt_refused;
  }
  world->simulation->set_gravity({x, y, z});
  world->changed();
  return mt_ok;
}

EXPORT(mt_grab) int mt_grab(MtWorld* world, int body, double x, double y, double z, double strength) {
  if (!world->body_name(body)) return mt_refused;
  mt_release_grip(world);
  world->grip = io::grip_on(world->simulation->world(), body, {x, y, z}, strength);
  world->apply_grip(body);
  return mt_ok;
}
EXPORT(mt_pull) void mt_pull(MtWorld* world, double x, double y, double z) {
  if (world->grip.body < 0) return;
  world->grip.target = {x, y, z};
  world->apply_grip(world->grip.body);
}
EXPORT(mt_release_grip) void mt_release_grip(MtWorld* world) {
  const int body = world->grip.body;
  world->grip = {};
  if (body >= 0 && world->simulation->world().alive({body})) world->apply_grip(body);
}

EXPORT(mt_snapshot) int mt_snapshot(MtWorld* world) {
  const Simulation& simulation = *world->simulation;
  wasm::Store& store = *world->store;
  store.snapshots.emplace(store.next, simulation.snapshot());
  return store.next++;
}
EXPORT(mt_restore) int mt_restore(MtWorld* world, int snapshot) {
  const auto found = world->store->snapshots.find(snapshot);
  if (found == world->store->snapshots.end()) {
    world->text = "there is no snapshot with that number";
    return mt_refused;
  }
  world->simulation->restore(found->second);
  world->after_restore();
  return mt_ok;
}
EXPORT(mt_drop) void mt_drop(MtWorld* world, int snapshot) { world->store->snapshots.erase(snapshot); }

EXPORT(mt_undo) int mt_undo(MtWorld* world, int event, int again) {
  Simulation& simulation = *world->simulation;
  if (event < 0 || !simulation.can_undo(static_cast<size_t>(event))) {
    world->text = "the history of event " + std::to_string(event) + " was not kept";
    return mt_refused;
  }
  simulation.undo(static_cast<size_t>(event), again != 0);
  world->after_restore();
  return mt_ok;
}

EXPORT(mt_branch) MtWorld* mt_branch(const MtWorld* world) {
  auto* other = new MtWorld;
  other->scenario = world->scenario;
  other->simulation = std::make_unique<Simulation>(world->simulation->branch());
  other->simulation->keep_history();
  other->thresholds = world->thresholds;
  other->store = world->store;
  other->after_restore();
  return other;
}
