#include <momentree/pages/page_run.hpp>

#include <limits>
#include <utility>

#include <momentree/pages/floor.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/scenario/events/schedule.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

namespace {

/// Refuses what needs files that do not exist here.
ReadResult read(std::string_view text) {
  ReadResult result = read_scenario_text(text, "scenario.toml");
  if (!result.scenario || result.scenario->state_files.empty()) return result;
  result.scenario.reset();
  result.diagnostics.push_back(
      {Severity::error, "", 0, 0, "state: files can't be read here; leave the state document out", "", ""});
  return result;
}

std::string diagnostics_json(const std::vector<Diagnostic>& diagnostics) {
  std::string text;
  JsonWriter json(text);
  json.begin_array();
  for (const Diagnostic& d : diagnostics) {
    json.begin_object().member("severity", word_of(d.severity)).member("line", d.line).member("column", d.column);
    json.member("what", d.what).member("hint", d.hint).end_object();
  }
  json.end_array();
  return text;
}

}  // namespace

std::string checked_json(std::string_view text) {
  return message_json("checked", "diagnostics", diagnostics_json(read(text).diagnostics));
}

bool PageRun::load(std::string_view text, bool floor) {
  ReadResult result = read(text);
  const std::string diagnostics = diagnostics_json(result.diagnostics);
  if (!result.scenario) {
    host_.post(loaded_json(diagnostics), {});
    return false;
  }
  const bool changed = floor && put_on_floor(*result.scenario);
  scenario_ = std::make_shared<const Scenario>(std::move(*result.scenario));
  auto simulation = std::make_unique<Simulation>(scenario_->model, scenario_->integration);
  std::vector<const ScenarioEvent*> scheduled;
  for (const ScenarioEvent& event : scenario_->events) scheduled.push_back(&event);
  schedule(*simulation, std::move(scheduled));  // the reader has found no problems with them
  begin(std::move(simulation));
  thresholds_ = thresholds_of(*scenario_, simulation_->world());
  store_ = std::make_shared<Store>();
  pose_.clear(), posed_.clear();
  const PageFrame first = frame_of(*simulation_, thresholds_);
  const World& world = simulation_->world();
  host_.post(loaded_json(diagnostics, scenario_json(*scenario_, scenario_->model.gravity(), changed),
                         model_json(world, scenario_->title, scenario_->shapes), topology_json(world), frame_json(first, false)),
             first.bytes);
  return true;
}

void PageRun::begin(std::unique_ptr<Simulation> simulation) {
  controls_.reset();
  simulation_ = std::move(simulation);
  simulation_->keep_history();
  controls_.emplace(*simulation_);
}

void PageRun::obey(Message& message) {
  static constexpr MessageHandler<PageRun> handlers[] = {
      {"load",
       [](PageRun& run, Message& m) {
         const std::string text = m.text("text");
         if (const bool floor = m.flag("floor", false); m.ok()) run.load(text, floor);
       }},
      {"topology", [](PageRun& run, Message&) { run.post("topology", "topology", topology_json(run.simulation_->world())); }},
      {"events",
       [](PageRun& run, Message& m) {
         const auto first = static_cast<std::size_t>(m.index("first"));
         if (m.ok()) run.post("events", "events", "[" + event_list(run.simulation_->events(), first) + "]");
       }},
      {"frame", [](PageRun& run, Message&) { run.post_frame(); }},
      {"run", [](PageRun& run, Message& m) { run.run_message(m); }},
      {"pose", [](PageRun& run, Message& m) { run.pose_message(m); }},
      {"snapshot",
       [](PageRun& run, Message&) {
         Store& store = *run.store_;
         store.snapshots.emplace(store.next, run.simulation_->snapshot());
         run.post("snapshot", "snapshot", std::to_string(store.next++));
       }},
      {"restore",
       [](PageRun& run, Message& m) {
         const auto found = run.store_->snapshots.find(m.index("snapshot"));
         if (found == run.store_->snapshots.end()) return m.refuse("there is no snapshot with that number");
         run.restore(found->second);
       }},
      {"drop", [](PageRun& run, Message& m) { run.store_->snapshots.erase(m.index("snapshot")); }},
      {"undo", [](PageRun& run, Message& m) {
         const int event = m.index("event");
         const bool again = m.flag("again", false);
         if (m.ok() && !run.undo(event, again)) m.refuse("the history of event " + std::to_string(event) + " was not kept");
       }}};
  if (!loaded() && message.type() != "load")
    message.refuse("load a scenario first");
  else if (!carry_out(message, *this, handlers) && !controls_->obey(message))
    message.refuse("there is no message '" + message.type() + "' for this world");
  if (!message.ok()) host_.post(report_json("refused", message.refusal()), {});
}

RunResult PageRun::run(double time, double budget) {
  if (!(time > simulation_->time())) return {};
  const double end = host_.clock() + budget;
  simulation_->watch([clock = host_.clock, end](double) { return clock() < end; });
  RunResult result = simulation_->run_until(time);
  if (result == Status::interrupted && simulation_->time() >= time) result.status = Status::ok;
  return result;
}

void PageRun::restore(const SimulationSnapshot& snapshot) {
  simulation_->restore(snapshot);
  after_restore();
}

bool PageRun::undo(int event, bool again) {
  if (!simulation_->can_undo(static_cast<std::size_t>(event))) return false;
  simulation_->undo(static_cast<std::size_t>(event), again);
  after_restore();
  return true;
}

void PageRun::after_restore() {
  controls_->forget();
  std::vector<std::string> pulled;
  for (const Topology::Loaded& load : simulation_->world().tree().loads().functions)
    pulled.push_back(simulation_->world().model()[{load.body}].name);
  for (const std::string& body : pulled) simulation_->force(body, {});
}

std::unique_ptr<PageRun> PageRun::branch() const {
  auto other = std::make_unique<PageRun>(host_);
  if (!loaded()) return other;
  other->scenario_ = scenario_;
  other->begin(std::make_unique<Simulation>(simulation_->branch()));
  other->thresholds_ = thresholds_;
  other->store_ = store_;
  other->after_restore();
  return other;
}

void PageRun::post_frame(double seconds) const {
  const PageFrame frame = frame_of(*simulation_, thresholds_);
  std::string text;
  JsonWriter json(text);
  json.begin_object().member("type", "frame").member("seconds", seconds).key("frame").raw(frame_json(frame, false)).end_object();
  host_.post(text, frame.bytes);
}

void PageRun::run_message(Message& message) {
  const double time = message.number("time"), budget = message.number("budget");
  if (!message.ok()) return;
  const RunResult result = run(time, budget);
  if (result == Status::refused) message.refuse(result.reason);
  if (result == Status::interrupted) host_.post(report_json("interrupted", ""), {});
  if (result == Status::diverged || result == Status::stalled) host_.post(report_json("diverged", result.reason), {});
}

void PageRun::pose_message(Message& message) {
  std::vector<double> q;
  if (const Value::Array* const all = message.any("q").array())
    for (const Value& each : *all) q.push_back(each.number().value_or(std::numeric_limits<double>::quiet_NaN()));
  std::size_t needed = 0;
  for (const BodySpec& body : scenario_->model.bodies()) needed += static_cast<std::size_t>(info(body.joint.kind).nq);
  if (q.size() != needed) return message.refuse("message 'pose': q must be a list of " + std::to_string(needed) + " coordinates");
  pose(scenario_->model, q.data(), pose_, posed_);
}

const std::vector<double>& PageRun::numbers(Numbers which) {
  numbers_.clear();
  if (which == Numbers::pose) return pose_;
  if (which == Numbers::posed) return posed_;
  if (!loaded()) return numbers_;
  const World& world = simulation_->world();
  switch (which) {
    case Numbers::state:
      numbers_ = {simulation_->time(), double(world.tree().revision()), double(simulation_->events().size()),
                  double(world.model().size()), double(joint_row_count(world))};
      break;
    case Numbers::motions: fill_motions(world, numbers_); break;
    case Numbers::joints: fill_joints(*simulation_, thresholds_, false, numbers_); break;
    case Numbers::reactions: fill_joints(*simulation_, thresholds_, true, numbers_); break;
    case Numbers::totals: numbers_.resize(totals_size), fill_totals(*simulation_, numbers_.data()); break;
    default: fill_contacts(world, numbers_);
  }
  return numbers_;
}

}  // namespace momentree::io
