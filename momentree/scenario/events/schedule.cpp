#include <momentree/scenario/events/schedule.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <momentree/simulate/events/instant.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

namespace {

using At = std::pair<std::size_t, std::size_t>;  // an event in the order of the schedule, and the index of one of its actions

class ScheduleChecker {
 public:
  ScheduleChecker(const DryRun& dry_run, const Schedule& schedule, const std::function<std::string(Place)>& name_of)
      : dry_run_(dry_run), schedule_(schedule), name_of_(name_of) {
    for (const DryRun::Issue& issue : dry_run.issues) {
      idle_.insert({issue.event, issue.action});
      if (issue.result.outcome == ActionResult::Outcome::refused) first_refused_ = std::min(first_refused_, issue.event);
    }
    for (std::size_t e = 0; e < schedule.events.size(); ++e)
      for (std::size_t a = 0; a < schedule.events[e]->actions.size(); ++a)
        if (const ActionBase& action = *event(e).actions[a]; action.reshapes() != 0)
          for (const std::string& joint : action.joints()) decided_[joint].push_back({e, a});
  }

  std::vector<EventProblem> problems() {
    for (const DryRun::Issue& issue : dry_run_.issues) check(issue);
    return std::move(found_);
  }

 private:
  const ScenarioEvent& event(std::size_t e) const { return *schedule_.events[e]; }
  const ActionBase& action(const At& at) const { return *event(at.first).actions[at.second]; }
  std::string key(const At& at) const { return std::string(action(at).key()); }
  std::string thing(const At& at) const {
    const std::string name = action(at).joints().front();
    return (schedule_.springs.contains(name) ? "spring " : "joint ") + in_quotes(name);
  }
  std::string described(const At& at) const {
    const ScenarioEvent& e = event(at.first);
    return e.actions[at.second].text() + " (event " + in_quotes(e.name) + ", " + name_of_(e.places[at.second]) + ")";
  }
  void add(const At& at, std::string what, std::string hint = {}) {
    found_.push_back({event(at.first).places[at.second], key(at) + ": " + std::move(what), std::move(hint)});
  }

  void check(const DryRun::Issue& issue) {
    const At at{issue.event, issue.action};
    if (issue.result.outcome == ActionResult::Outcome::refused) return check_refused(at, issue.result);
    // After a refused action, problems of later ones may be consequences.
    if (event(at.first).wild || issue.event > first_refused_) return;
    const std::size_t first = found_.size();
    const At* before = origin(at);
    // Any match of a condition may never happen.
    if (before != nullptr && event(before->first).wild && event(before->first).condition) return;
    const JointEffect effect = action(at).effect();
    const bool removed = before != nullptr && action(*before).effect() == JointEffect::removed;
    if (removed && effect == JointEffect::removed)
      add(at, thing(at) + " is broken already on " + place(*before),
          std::string(schedule_.springs.contains(action(at).joints().front()) ? "a spring" : "a joint") + " can break only once");
    else if (removed && (effect == JointEffect::held || effect == JointEffect::replaced))
      add(at, thing(at) + " will be broken by then, by " + described(*before),
          "to hold the separated part where it is, weld its body to the ground");
    else if (before != nullptr)
      add(at, "does nothing: " + issue.result.why + ", after " + described(*before));
    else
      add(at, "does nothing: " + issue.result.why + made_later(at));
    for (std::size_t i = first; i < found_.size(); ++i) found_[i].idle = true;
  }

  std::string place(const At& at) const { return name_of_(event(at.first).places[at.second]); }

  // The last earlier action that changed the same joint.
  const At* origin(const At& at) const {
    const At* last = nullptr;
    for (const std::string& joint : action(at).joints()) {
      const auto found = decided_.find(joint);
      if (found == decided_.end()) continue;
      for (const At& each : found->second)
        if (each < at && !idle_.contains(each)) last = &each;
    }
    return last;
  }

  std::string made_later(const At& at) const {
    for (const std::string& joint : action(at).joints())
      for (std::size_t e = at.first; e < schedule_.events.size(); ++e)
        for (std::size_t a = 0; a < event(e).actions.size(); ++a)
          if (!event(e).actions[a]->makes().empty() &&
              made_joint_name({event(e).name, event(e).named, event(e).actions}, a) == joint)
            return " yet: it is made by " + described({e, a});
    return "";
  }

  void check_refused(const At& at, const ActionResult& result) {
    std::string why = result.why;
    for (const std::string& joint : action(at).joints()) {
      const auto found = decided_.find(joint);
      if (found == decided_.end() || !why.starts_with("contradicts ")) continue;
      for (const At& each : found->second) {
        const ScenarioEvent& other = event(each.first);
        const std::string text = other.actions[each.second].text() + " (event '" + other.name + "')";
        if (each == at || other.time != event(at.first).time || why.find(text) == std::string::npos) continue;
        why += ", on " + place(each);
        break;
      }
    }
    add(at, why, result.hint);
  }

  const DryRun& dry_run_;
  const Schedule& schedule_;
  const std::function<std::string(Place)>& name_of_;
  std::set<At> idle_;
  std::size_t first_refused_ = static_cast<std::size_t>(-1);
  std::map<std::string, std::vector<At>> decided_;  // the actions that change a joint, in the order of the schedule
  std::vector<EventProblem> found_;
};

}  // namespace

namespace {

// An event after another one is scheduled after it; if that event does not exist, it is a problem.
Schedule with_followers(std::vector<const ScenarioEvent*> events, const Simulation& simulation) {
  Schedule all;
  std::set<std::string> names;
  for (const Spring& spring : simulation.world().model().springs()) all.springs.insert(spring.name);
  for (const BodySpec& body : simulation.world().model().bodies())  // joints break by themselves, too
    if (body.joint.parameters.strength.any()) names.insert("strength of " + body.joint_name);
  for (const Spring& spring : simulation.world().model().springs())
    if (std::isfinite(spring.strength)) names.insert("strength of " + spring.name);
  for (const LoopSpec& loop : simulation.world().model().loops())
    if (loop.joint.parameters.strength.any()) names.insert("strength of " + loop.name);
  std::vector<const ScenarioEvent*> waiting;
  for (const ScenarioEvent* event : events) {
    if (!event->after.empty()) {
      waiting.push_back(event);
      continue;
    }
    names.insert(event->name);
    all.events.push_back(event);
  }
  for (bool more = true; more;) {
    more = false;
    for (const ScenarioEvent*& event : waiting) {
      if (event == nullptr || !names.contains(event->after)) continue;
      names.insert(event->name);
      all.events.push_back(event);
      event = nullptr;
      more = true;
    }
  }
  for (const ScenarioEvent* event : waiting)
    if (event != nullptr)
      all.problems.push_back({event->after_place,
                              "after: there is no event " + in_quotes(event->after) + " that could come before",
                              did_you_mean(event->after, {names.begin(), names.end()})});
  return all;
}

}  // namespace

Schedule schedule(Simulation& simulation, std::vector<const ScenarioEvent*> events, const std::vector<ScenarioEvent>& past) {
  std::vector<std::string> made;
  const auto note = [&made](const ScenarioEvent& event) {
    for (std::size_t a = 0; a < event.actions.size(); ++a)
      if (std::string name = made_joint_name({event.name, event.named, event.actions}, a); !name.empty())
        made.push_back(std::move(name));
  };
  for (const ScenarioEvent* event : events) note(*event);
  for (const ScenarioEvent& event : past) note(event);
  expect_joints(simulation, made);
  std::map<const ScenarioEvent*, std::size_t> ranks;  // by position in the file
  for (std::size_t k = 0; k < events.size(); ++k) ranks.emplace(events[k], k);
  std::stable_sort(events.begin(), events.end(), [](const auto* a, const auto* b) { return a->time < b->time; });
  Schedule all = with_followers(std::move(events), simulation);
  std::set<std::string> refused;  // events with a wrong condition, and those that come after them
  for (const ScenarioEvent* event : all.events) {
    if (!event->after.empty() && refused.contains(event->after)) {
      refused.insert(event->name);
      continue;
    }
    std::optional<Simulation::Scheduled> condition;
    if (event->condition) {
      Condition given = *event->condition;
      given.least_norm = given.least_norm || simulation.time() > 0;  // the run that wrote the document went on, too
      if (const std::optional<Error> error = simulation.check(given)) {
        all.problems.push_back({event->place, "when: " + error->problem, error->hint});
        refused.insert(event->name);
        continue;
      }
      condition = simulation.when(std::move(given));
    }
    Simulation::Scheduled scheduled = [&] {
      if (condition) return *condition;
      if (!event->after.empty()) return simulation.after(event->after, event->delay);
      if (event->period > 0) return simulation.every(event->period, event->time);
      return simulation.at(event->time);
    }();
    scheduled.named(event->name, event->named).ranked(ranks.at(event));
    for (std::size_t a = 0; a < event->actions.size(); ++a) {
      if (const std::optional<Error> error = simulation.check(event->actions[a]))
        all.problems.push_back({event->places[a], std::string(event->actions[a]->key()) + ": " + error->problem, error->hint});
      else
        scheduled.then(event->actions[a]);
    }
  }
  return all;
}

std::vector<EventProblem> problems_of(const DryRun& dry_run, const Schedule& schedule,
                                      const std::function<std::string(Place)>& name_of) {
  return ScheduleChecker(dry_run, schedule, name_of).problems();
}

}  // namespace momentree::io
