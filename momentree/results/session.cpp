#include <momentree/results/session.hpp>

#include <algorithm>
#include <cmath>
#include <new>
#include <unordered_set>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/text/files/input_cache.hpp>
#include <momentree/text/files/text_file.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

Simulation simulation_of(const Scenario& scenario) {
  try {
    return Simulation(scenario.model, scenario.integration);
  } catch (const std::bad_alloc&) {
    throw_error({"not enough free memory for " + std::to_string(scenario.model.size()) + " bodies", scenario.path,
                 "about 3 kB are needed for each body"});
  }
}

}  // namespace

Session::Session(std::shared_ptr<const Scenario> scenario, std::vector<RestoredState> documents)
    : shared_(std::move(scenario)), simulation_(simulation_of(*shared_)) {
  for (const ScenarioEvent& event : shared_->events) {
    const auto [place, fresh] = by_name_.emplace(event.name, armed_at_start_.size());
    if (fresh) armed_at_start_.push_back({event.name}), matches_.emplace_back();
    std::vector<const ScenarioEvent*>& matches = matches_[place->second];
    match_of_.emplace(&event, matches.size());
    matches.push_back(&event);
  }

  if (documents.empty())
    for (const StateFile& file : shared_->state_files)
      documents.push_back(read_state(shared_->inputs ? shared_->inputs->text(file.file) : read_text_file(file.file), file.file,
                                     shared_->model, file.mechanism));
  if (!documents.empty()) {
    from_document_ = true;
    of_documents_ = restore(simulation_, documents);
  }
  for (const RestoredState& document : documents) {
    if (document.memory != StepMemory{}) memory_ = document.memory;
    for (const ArmedEvent& event : document.armed) take_armed(event, document.file);
  }
  if (from_document_) momentree::resume(simulation_, {}, memory_);
}

void Session::take_armed(const ArmedEvent& event, const std::string& file) {
  const auto place = by_name_.find(event.name);
  if (place == by_name_.end()) {
    std::vector<std::string> names;
    for (const auto& known : armed_at_start_) names.push_back(known.name);
    throw_error({"`armed` names an unknown event '" + event.name + "'", file, did_you_mean(event.name, names)});
  }
  const std::size_t matches = matches_[place->second].size();
  if (!event.each.empty() && event.each.size() != matches)
    throw_error({"`armed` has " + std::to_string(event.each.size()) + " entries for event '" + event.name + "', which has " +
                     std::to_string(matches) + " matches",
                 file, "is it a document of this scenario?"});
  armed_at_start_[place->second] = event;
}

// The state of an event, or of its wildcard match, in the document; null: there is none.
const EventStatus* Session::past_of(const ScenarioEvent& event) const {
  const std::vector<EventStatus>& each = armed_at_start_[by_name_.at(event.name)].each;
  return each.empty() ? nullptr : &each[match_of_.at(&original(event))];
}

bool Session::has_happened(const ScenarioEvent& event) const {
  const EventStatus* const past = past_of(event);
  return (past != nullptr ? past->fired : armed_at_start_[by_name_.at(event.name)].fired) > 0;
}

const ScenarioEvent& Session::original(const ScenarioEvent& event) const {
  const auto found = original_.find(&event);
  return found == original_.end() ? event : *found->second;
}

// Events after an event that was over before the run began happen when they are due, or never.
void Session::schedule_followers(std::vector<const ScenarioEvent*>& events) {
  for (bool more = true; more;) {  // a dropped event may have followers itself
    more = false;
    std::unordered_set<std::string> names;
    for (const ScenarioEvent* event : events) names.insert(event->name);
    for (const ScenarioEvent*& event : events) {
      if (event->after.empty() || names.contains(event->after) || !by_name_.contains(event->after)) continue;
      const EventStatus* const past = past_of(*event);
      const ScenarioEvent* const declared = event;
      more = true;
      event = nullptr;
      if (past == nullptr || !std::isfinite(past->time)) continue;
      pending_.push_back(*declared);
      pending_.back().after.clear();
      pending_.back().time = past->time;
      event = &pending_.back();
      original_.emplace(event, declared);
    }
    std::erase(events, nullptr);
  }
}

std::vector<Diagnostic> Session::schedule() {
  MT_REQUIRE(!has_events_, "the events of a session are scheduled once; load() has done so");
  has_events_ = true;
  std::vector<Diagnostic> found = std::move(of_documents_);
  const auto warn = [&](Place place, std::string what) {
    found.push_back({Severity::warning, scenario().path, place.line, place.column, std::move(what), "", ""});
  };
  const double start = simulation_.time();
  if (const Vec3 g = simulation_.world().model().gravity(); !(g == simulation_.world().start().gravity))
    warn({}, "gravity is that of the state document: [" + number_text(g.x) + ", " + number_text(g.y) + ", " + number_text(g.z) +
                 "] m/s²");
  std::vector<const ScenarioEvent*> events;
  for (const ScenarioEvent& event : scenario().events) {
    const bool fired = has_happened(event);
    const bool once = !(event.condition && event.condition->repeats) && event.after.empty() && event.period == 0;
    if (event.condition && fired && once) continue;
    if (event.period == 0 && (event.time < start || (event.time == start && fired))) {
      if (!fired)
        warn(event.place, "event '" + event.name + "' at " + number_text(event.time) + " s does not happen: the run starts at " +
                              number_text(start) + " s");
      continue;
    }
    events.push_back(&event);
  }
  if (from_document_) schedule_followers(events);
  scheduled_ = io::schedule(simulation_, std::move(events), scenario().events);
  if (scheduled_.problems.empty()) resume();  // first: a document stores instants to the last bit
  std::vector<EventProblem> problems = scheduled_.problems;
  if (problems.empty() && from_document_) {  // otherwise the reader has tried them
    const auto line = [](Place place) { return "line " + std::to_string(place.line); };
    DryRun dry_run = simulation_.dry_run();
    // The run that wrote the document may have ended before they are due, or went on past them.
    std::erase_if(dry_run.issues, [this](const DryRun::Issue& issue) {
      return issue.time > scenario().until || has_happened(*scheduled_.events[issue.event]);
    });
    problems = problems_of(dry_run, scheduled_, line);
    // An action with no effect is not an error: the run that wrote the document continued past such actions, too.
    std::erase_if(problems, [&](const EventProblem& problem) {
      if (problem.idle) warn(problem.place, problem.what);
      return problem.idle;
    });
  }
  if (!problems.empty()) {
    const EventProblem& first = problems.front();
    throw_error({first.what, scenario().path + ":" + std::to_string(first.place.line) + ":" + std::to_string(first.place.column),
                 first.hint});
  }
  return found;
}

// Resumes from the state of the document's run.
void Session::resume() {
  if (!from_document_) return;
  std::vector<EventStatus> armed = simulation_.snapshot().armed;
  for (std::size_t k = 0; k < scheduled_.events.size(); ++k)
    if (const EventStatus* past = past_of(*scheduled_.events[k])) armed[k] = *past;
  momentree::resume(simulation_, armed, memory_);
}

Armed Session::armed(const Simulation& branch) const {
  Armed armed = armed_at_start_;
  for (const Event& event : branch.events())
    if (const auto place = by_name_.find(event.name); place != by_name_.end()) ++armed[place->second].fired;
  const std::vector<EventStatus> now = branch.snapshot().armed;
  std::unordered_map<const ScenarioEvent*, const EventStatus*> scheduled;
  for (std::size_t k = 0; k < scheduled_.events.size(); ++k) scheduled.emplace(&original(*scheduled_.events[k]), &now[k]);
  for (std::size_t place = 0; place < armed.size(); ++place) {
    const auto& matches = matches_[place];
    const ScenarioEvent& first = *matches.front();
    if (!first.condition && first.after.empty() && first.period == 0) continue;  // its instant is sufficient
    std::vector<EventStatus> each;
    for (const ScenarioEvent* event : matches) {
      const auto at = scheduled.find(event);
      const EventStatus* const past = past_of(*event);
      if (at != scheduled.end()) {
        each.push_back(*at->second);
        if (!event->after.empty() && each.back().done)  // only because the event that it follows is over
          each.back().done = false, each.back().time = HUGE_VAL;
      } else if (past != nullptr)
        each.push_back(*past);
    }
    if (each.size() == matches.size()) armed[place].each = std::move(each);
  }
  return armed;
}

std::vector<JointKinds> Session::joints() { return joints_of(simulation_, simulation_.dry_run(), scenario()); }

namespace {

Session started(ReadResult read, const LoadOptions& options) {
  if (!read.scenario) throw InputError(std::move(read.diagnostics));
  auto scenario = std::make_shared<const Scenario>(std::move(*read.scenario));
  std::vector<RestoredState> documents;
  if (!options.state.empty()) documents.push_back(read_state(read_text_file(options.state), options.state, scenario->model));
  Session session(std::move(scenario), std::move(documents));
  session.warnings = std::move(read.diagnostics);
  for (Diagnostic& warning : session.schedule()) session.warnings.push_back(std::move(warning));
  return session;
}

}  // namespace

Session load(const std::string& path, const LoadOptions& options) {
  return started(read_scenario(path, options.overrides), options);
}

Session load_text(std::string text, const std::string& name, const LoadOptions& options) {
  return started(read_scenario_from(std::move(text), name, name, "", options.overrides), options);
}

RunResult Session::run() { return simulation_.run_until(scenario().until); }

}  // namespace momentree::io
