#include <tests/fuzz/traced_run.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

#include <momentree/base/error.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/results/checkpoint/checkpoint.hpp>
#include <momentree/results/results.hpp>
#include <momentree/scenario/state/joint_json.hpp>
#include <momentree/simulate/events/topology_record.hpp>

namespace momentree::fuzz {

namespace {

// The bits of a number, without the sign of zero: a document chooses the sign of a quaternion, and the signs of zeros that follow
// from one differ.
void append(std::string& text, double value) {
  value += 0.0;
  char bits[sizeof value];
  std::memcpy(bits, &value, sizeof value);
  text.append(bits, sizeof bits);
}

}  // namespace

std::string event_text(Event event) {
  event.duration_ns = 0;
  std::sort(event.impulse.begin(), event.impulse.end());  // they are ordered by joint number, which a restart reassigns
  return io::event_json(event);
}

std::string row_text(const Simulation& simulation) {
  const World& world = simulation.world();
  std::string text;
  append(text, world.time());
  for (const BodyMotion& motion : world.motions()) {
    const Quat& r = motion.pose.rotation;
    const double sign = std::signbit(r.w) ? -1 : 1;  // the sign of a quaternion is meaningless
    for (const double x : {sign * r.w, sign * r.x, sign * r.y, sign * r.z}) append(text, x);
    for (const Vec3& v : {motion.pose.position, motion.linear, motion.angular})
      for (const double x : {v.x, v.y, v.z}) append(text, x);
  }
  return text;
}

std::string joint_text(const JointRecord& joint) {
  std::string text;
  io::JsonWriter json(text);
  json.begin_object();
  io::write_joint_frame(json, joint);
  io::write_locked(json, joint.locked, info(joint.kind).nv);
  json.end_object();
  return text;
}

namespace {

void describe(const World& world, std::map<std::string, std::string>& joints, std::vector<std::string>& mechanisms) {
  for (const JointId joint : present_joints(world))
    joints.emplace(world.joint_name(joint), joint_text(joint_record(world, joint)));
  mechanisms.resize(static_cast<std::size_t>(world.tree().bodies()));
  for (const Mechanism& mechanism : world.mechanisms())
    for (const BodyId body : mechanism.bodies) mechanisms[static_cast<std::size_t>(body.index)] = mechanism.name;
}

}  // namespace

std::string difference(const std::string& one, const std::string& other) {
  const auto apart = std::mismatch(one.begin(), one.end(), other.begin(), other.end());
  if (apart.first == one.end() && apart.second == other.end()) return "";
  const auto around = [](const std::string& text, std::string::const_iterator at) {
    const auto place = static_cast<std::size_t>(at - text.begin());
    const std::size_t from = place > 400 ? place - 400 : 0;
    return text.substr(from, place - from) + "<<<" + text.substr(place, 120);
  };
  return around(one, apart.first) + "\n--- but\n" + around(other, apart.second);
}

namespace {

std::string counts_of(const Simulation& simulation) {
  const RunStatistics& run = simulation.statistics();
  std::string text;
  for (const long count : {run.steps, run.changes, run.evaluations[0], run.evaluations[1]}) text += std::to_string(count) + ' ';
  const EnergyBalance e = simulation.energy();
  for (const double x : {e.initial, e.final, e.dissipated, e.work, e.lost_in_impacts, e.released, e.error, e.largest_kinetic})
    append(text, std::isnan(x) ? -1 : x);
  for (const MissedEvent& missed : simulation.missed()) {
    text += missed.name;
    for (const double x : {missed.time, missed.nearest, missed.nearest_time, missed.held}) append(text, std::isnan(x) ? -1 : x);
  }
  return text;
}

std::unique_ptr<io::Session> new_session(const io::Scenario& scenario, const RunPlan& plan) {
  auto session = std::make_unique<io::Session>(scenario, cli::documents_of(plan.state, scenario.model));
  static_cast<void>(session->schedule());
  return session;
}

}  // namespace

Trace traced_run(const io::Scenario& scenario, const RunPlan& plan) {
  Trace trace;
  std::unique_ptr<io::Session> session;
  try {
    session = new_session(scenario, plan);
  } catch (const Error& error) {
    trace.refused = error.message();
    return trace;
  }
  describe(session->simulation().world(), trace.joints_before, trace.mechanisms_before);
  std::string saved;
  std::size_t next = 0;
  do {
    if (!saved.empty()) session = new_session(scenario, plan);
    Simulation& simulation = session->simulation();
    simulation.observe(scenario.output_every, [&](const World& world) {
      // Of two rows at one instant the later one counts: it follows the events.
      if (!trace.times.empty() && trace.times.back() == world.time()) trace.times.pop_back(), trace.rows.pop_back();
      trace.times.push_back(world.time());
      trace.rows.push_back(row_text(simulation));
      if (plan.at_rows) plan.at_rows(simulation);
      return true;
    });
    if (plan.after_steps)
      simulation.sample([&](const World&) {
        plan.after_steps(simulation);
        return true;
      });
    simulation.watch([&](double) {
      ++trace.steps;
      if (next < plan.saved_after.size() && trace.steps == plan.saved_after[next]) {
        saved = io::checkpoint_bytes({{}, 0, simulation.run_state(), {}});
        return false;
      }
      return trace.steps < plan.most_steps;
    });
    if (!saved.empty()) {
      const io::Checkpoint checkpoint = io::read_checkpoint(saved, "saved");
      io::require_fit(simulation, checkpoint, "saved");
      io::continue_run(simulation, checkpoint);
      saved.clear(), ++next;
    }
    trace.status = simulation.run_until(plan.until);
  } while (!saved.empty());
  const Simulation& simulation = session->simulation();
  trace.cut = trace.status == Status::interrupted;
  if (trace.status != Status::ok) trace.message = simulation.result().reason;
  describe(simulation.world(), trace.joints_after, trace.mechanisms_after);
  trace.certificates = simulation.events();
  for (const Event& event : trace.certificates) trace.events.push_back(event_text(event));
  trace.state = io::state_json(simulation.world(), session->armed(), step_memory(simulation));
  trace.counts = counts_of(simulation);
  trace.energy = simulation.energy();
  trace.time = simulation.time();
  return trace;
}

}  // namespace momentree::fuzz
