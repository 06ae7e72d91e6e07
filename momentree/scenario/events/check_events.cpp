// Checks that need all events: parts without mass, and actions that are impossible or have no effect when they happen.
#include <algorithm>
#include <cmath>
#include <map>

#include <momentree/base/periodic.hpp>
#include <momentree/scenario/events/schedule.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/simulate/arguments.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

// The limit on events times bodies, beyond which a dry run takes longer than a user waits for a check.
constexpr std::size_t most_dry_run = 4'000'000;

using Broken = std::map<std::string, Place>;

// First places of breaks; if `doubles`, second ones are reported.
Broken broken_joints(Reading& reading, bool doubles) {
  Broken broken;
  for (const ScenarioEvent& event : reading.scenario.events)
    for (std::size_t a = 0; a < event.actions.size(); ++a) {
      if (event.actions[a]->effect() != JointEffect::removed) continue;
      for (const std::string& joint : event.actions[a]->joints()) {
        const auto [first, fresh] = broken.emplace(joint, event.places[a]);
        if (!fresh && doubles && !event.wild)
          reading.out.error(event.places[a],
                            std::string(event.actions[a]->key()) + ": joint " + in_quotes(joint) + " is broken already on " +
                                reading.out.name_of(first->second),
                            "a joint can break only once");
      }
    }
  return broken;
}

// With every break carried out, the parts are the smallest that can occur: a DoF that still moves mass then always does.
void check_parts(const Broken& broken, Reading& reading) {
  const Model& model = reading.scenario.model;
  Diagnostics& out = reading.out;
  Model apart(Model::Options{model.gravity()});
  std::vector<Place> place_of_body;
  for (const BodySpec& body : model.bodies()) {
    BodySpec spec = body;
    const auto found = broken.find(spec.joint_name);
    place_of_body.push_back(found == broken.end() ? Place{} : found->second);
    if (found != broken.end()) {
      spec.parent = ground;
      spec.at = spec.child_at = Pose{};
      spec.joint = JointSpec{};
      spec.joint.kind = Kind::free;
      spec.q = spec.v = Values{};
    }
    apart.add_unjudged(std::move(spec));
  }
  for (const SingularJoint& singular : singular_joints(apart)) {
    const Place place = place_of_body[static_cast<std::size_t>(singular.body.index)];
    const std::string joint = in_quotes(apart[singular.body].joint_name);
    if (place.line > 0 || place.option > 0)
      out.error(place, "break: the part that separates at " + joint + " lacks the mass or inertia to move freely",
                "give it a mass and an inertia about every axis");
    else
      out.error(broken.begin()->second, "break: joint " + joint + " would no longer move any mass", singular.hint);
  }
}

// The matches of a wildcard are adjacent events with the same place.
void check_periods(Reading& reading) {
  const std::vector<ScenarioEvent>& events = reading.scenario.events;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const ScenarioEvent& event = events[i];
    if (!(event.period > 0) || (i > 0 && events[i - 1].name == event.name)) continue;
    const double clock = std::max(event.time, reading.scenario.integration.step);
    if (const std::optional<Error> wrong = wrong_period(event.period, clock, "every: a period"))
      reading.out.error(event.place, wrong->problem, wrong->hint);
  }
}

}  // namespace

namespace {

// The earliest instants at which events of each name can happen; an event with a condition can happen at once.
std::unordered_map<std::string, double> earliest_instants(const Scenario& scenario) {
  std::unordered_map<std::string, double> earliest;
  const auto take = [&earliest](const std::string& name, double time) {
    const auto [known, fresh] = earliest.emplace(name, time);
    const bool sooner = fresh || time < known->second;
    if (sooner) known->second = time;
    return sooner;
  };
  for (const BodySpec& body : scenario.model.bodies())  // joints break by themselves, too
    if (body.joint.parameters.strength.any()) take("strength of " + body.joint_name, 0);
  for (const Spring& spring : scenario.model.springs())
    if (std::isfinite(spring.strength)) take("strength of " + spring.name, 0);
  for (const LoopSpec& loop : scenario.model.loops())
    if (loop.joint.parameters.strength.any()) take("strength of " + loop.name, 0);
  std::unordered_map<std::string_view, std::vector<const ScenarioEvent*>> followers;
  for (const ScenarioEvent& event : scenario.events) {
    if (event.after.empty())
      take(event.name, event.condition ? event.condition->duration : event.time);
    else
      followers[event.after].push_back(&event);
  }
  std::vector<std::string> sooner;
  for (const auto& [name, time] : earliest) sooner.push_back(name);
  while (!sooner.empty()) {
    const std::string name = std::move(sooner.back());
    sooner.pop_back();
    if (const auto found = followers.find(name); found != followers.end())
      for (const ScenarioEvent* event : found->second)
        if (take(event->name, earliest.at(name) + event->delay)) sooner.push_back(event->name);
  }
  return earliest;
}

// Reports events that come after the end. If the command line sets the end, this is assumed to be intended.
void warn_of_late(Reading& reading) {
  const Scenario& scenario = reading.scenario;
  if (reading.integrate.until.option > 0) return;
  const double end = scenario.until * (1 + 1e-12);
  const std::unordered_map<std::string, double> earliest = earliest_instants(scenario);
  const auto text = [](double x) { return rounded_text(x, 9); };
  for (const ScenarioEvent& event : scenario.events) {
    double time = event.condition ? event.condition->duration : event.time;
    if (!event.after.empty()) {
      const auto before = earliest.find(event.after);
      if (before == earliest.end()) continue;  // reported where it is scheduled
      time = delayed(before->second, event.delay);
    }
    if (!(time > end)) continue;
    const bool exact = !event.condition && event.after.empty();
    reading.out.warning(event.place,
                        "event " + in_quotes(event.name) + " cannot happen: it is due at " + text(time) + " s" +
                            (exact ? "" : " at the earliest") + ", but the run ends at " + text(scenario.until) + " s",
                        "make the run longer, as in until = \"" + text(time) + " s\", or the event earlier");
  }
}

}  // namespace

void check_events(Reading& reading) {
  const Scenario& scenario = reading.scenario;
  if (scenario.events.empty()) return;
  check_periods(reading);
  Diagnostics& out = reading.out;
  warn_of_late(reading);
  const auto whole = [](const StateFile& file) { return file.mechanism.empty(); };
  // the initial world is different: events are checked when it is restored
  if (std::any_of(scenario.state_files.begin(), scenario.state_files.end(), whole)) return;
  const std::size_t errors = out.errors();
  const bool small = scenario.events.size() * static_cast<std::size_t>(scenario.model.size()) <= most_dry_run;
  const auto joins = [](const ScenarioEvent& event) {
    return std::any_of(event.actions.begin(), event.actions.end(), [](const Action& a) { return !a->makes().empty(); });
  };
  const bool gives_mass = std::any_of(scenario.events.begin(), scenario.events.end(), joins);
  if (const Broken broken = broken_joints(reading, !small); !broken.empty() && !gives_mass) check_parts(broken, reading);
  if (!small || errors != out.errors()) return;

  Simulation simulation(scenario.model, scenario.integration);
  std::vector<const ScenarioEvent*> events;
  for (const ScenarioEvent& event : scenario.events) events.push_back(&event);
  const Schedule scheduled = schedule(simulation, std::move(events));
  std::vector<EventProblem> problems = scheduled.problems;
  const auto name_of = [&out](Place place) { return out.name_of(place); };
  if (problems.empty()) problems = problems_of(simulation.dry_run(), scheduled, name_of);
  for (EventProblem& problem : problems) out.error(problem.place, std::move(problem.what), std::move(problem.hint));
}

}  // namespace momentree::io
