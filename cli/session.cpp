#include <cli/session.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <new>
#include <unordered_set>
#include <utility>

#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/io/text_file.hpp>

namespace momentree::cli {

std::optional<io::Scenario> load(const std::string& path, const std::vector<std::string>& overrides, Notes notes,
                                 io::Severity least) {
  io::ReadResult result = read_input(path, overrides);
  if (notes == Notes::counted) count_notes(result);
  std::erase_if(result.diagnostics, [least](const io::Diagnostic& d) { return d.severity > least; });
  show(stderr, io::rendered(result.diagnostics));
  return std::move(result.scenario);
}

void refuse_to_overwrite(const std::string& out, const io::Scenario& scenario) {
  namespace fs = std::filesystem;
  const auto refuse = [&out](const fs::path& source) {
    std::error_code ignored;
    if (fs::equivalent(out, source, ignored))
      throw_error({"this is an input file: it would be overwritten", out, "give another name after -o"});
  };
  if (out == "-") return;
  refuse(scenario.path);
  for (const io::StateFile& state : scenario.state_files) refuse(state.file);
  const Value::Entry* const mechanisms = scenario.document->find("mechanism");
  if (mechanisms == nullptr || mechanisms->value.array() == nullptr) return;
  for (const Value& mechanism : *mechanisms->value.array())
    if (const Value::Entry* model = mechanism.find("model"); model != nullptr && model->value.string() != nullptr)
      refuse(fs::path(scenario.path).parent_path() / *model->value.string());
}

namespace {

Simulation simulation_of(const io::Scenario& scenario) {
  try {
    return Simulation(scenario.model, scenario.integration);
  } catch (const std::bad_alloc&) {
    throw_error({format("not enough free memory for %d bodies", scenario.model.size()), scenario.path,
                 "about 3 kB are needed for each body"});
  }
}

}  // namespace

Session::Session(const io::Scenario& scenario, const std::string& state)
    : scenario_(scenario), simulation_(simulation_of(scenario)) {
  for (const io::ScenarioEvent& event : scenario.events) {
    const auto [place, fresh] = by_name_.emplace(event.name, armed_at_start_.size());
    if (fresh) armed_at_start_.push_back({event.name}), matches_.emplace_back();
    std::vector<const io::ScenarioEvent*>& matches = matches_[place->second];
    match_of_.emplace(&event, matches.size());
    matches.push_back(&event);
  }

  std::vector<io::RestoredState> documents;
  if (is_standard_input(state))
    documents.push_back(read(read_standard_input(), {standard_input, "", {}}));
  else if (!state.empty())
    documents.push_back(read(io::read_text_file(state), {state, "", {}}));
  else
    for (const io::StateFile& file : scenario.state_files) documents.push_back(read(io::read_text_file(file.file), file));
  if (!documents.empty()) {
    from_document_ = true;
    io::restore(simulation_, documents);
  }
  io::couple(simulation_, scenario.couplings);
  for (const io::RestoredState& document : documents) {
    if (document.memory.next_step > 0) memory_ = document.memory;
    for (const io::ArmedEvent& event : document.armed) take_armed(event, document.file);
  }
}

void Session::take_armed(const io::ArmedEvent& event, const std::string& file) {
  const auto place = by_name_.find(event.name);
  if (place == by_name_.end()) {
    std::vector<std::string> names;
    for (const auto& known : armed_at_start_) names.push_back(known.name);
    throw_error({"`armed` names an unknown event '" + event.name + "'", file, did_you_mean(event.name, names)});
  }
  const std::size_t matches = matches_[place->second].size();
  if (!event.each.empty() && event.each.size() != matches)
    throw_error(
        {format("`armed` has %zu entries for event '%s', which has %zu matches", event.each.size(), event.name.c_str(), matches),
         file, "is it a document of this scenario?"});
  armed_at_start_[place->second] = event;
}

// The state of an event, or of its wildcard match, in the document; null: there is none.
const EventQueue::Armed* Session::past_of(const io::ScenarioEvent& event) const {
  const std::vector<EventQueue::Armed>& each = armed_at_start_[by_name_.at(event.name)].each;
  return each.empty() ? nullptr : &each[match_of_.at(&original(event))];
}

const io::ScenarioEvent& Session::original(const io::ScenarioEvent& event) const {
  const auto found = original_.find(&event);
  return found == original_.end() ? event : *found->second;
}

// Events after an event that was over before the run began happen when they are due, or never.
void Session::schedule_followers(std::vector<const io::ScenarioEvent*>& events) {
  for (bool more = true; more;) {  // a dropped event may have followers itself
    more = false;
    std::unordered_set<std::string> names;
    for (const io::ScenarioEvent* event : events) names.insert(event->name);
    for (const io::ScenarioEvent*& event : events) {
      if (event->after.empty() || names.contains(event->after) || !by_name_.contains(event->after)) continue;
      const EventQueue::Armed* const past = past_of(*event);
      const io::ScenarioEvent* const declared = event;
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

// Prints all problems of a document: the last one as the error that ends the program.
io::RestoredState Session::read(const std::string& text, const io::StateFile& document) const {
  std::vector<io::Diagnostic> problems;
  std::optional<io::RestoredState> state = io::read_state(text, document.file, scenario_.model, document.mechanism, problems);
  if (state) return std::move(*state);
  const Error last = problems.back().error();
  problems.pop_back();
  show(stderr, io::rendered(problems));
  throw_error(last);
}

std::vector<io::Diagnostic> Session::schedule() {
  std::vector<io::Diagnostic> warnings;
  const auto warn = [&](Place place, std::string what) {
    warnings.push_back({io::Severity::warning, scenario_.path, place.line, place.column, std::move(what), "", ""});
  };
  const double start = simulation_.time();
  std::vector<const io::ScenarioEvent*> events;
  for (const io::ScenarioEvent& event : scenario_.events) {
    const EventQueue::Armed* const past = past_of(event);
    const bool fired = (past != nullptr ? past->fired : armed_at_start_[by_name_.at(event.name)].fired) > 0;
    const bool once = !(event.condition && event.condition->repeats) && event.after.empty() && event.period == 0;
    if (event.condition && fired && once) continue;
    if (event.period == 0 && (event.time < start || (event.time == start && fired))) {
      if (!fired)
        warn(event.place,
             "event '" + event.name + format("' at %g s does not happen: the run starts at %g s", event.time, start));
      continue;
    }
    events.push_back(&event);
  }
  if (from_document_) schedule_followers(events);
  scheduled_ = io::schedule(simulation_, std::move(events), scenario_.events);
  if (scheduled_.problems.empty()) resume();  // first: a document stores instants to the last bit
  std::vector<io::EventProblem> problems = scheduled_.problems;
  if (problems.empty() && from_document_) {  // otherwise the reader has tried them
    const auto line = [](Place place) { return format("line %d", place.line); };
    problems = io::problems_of(simulation_.dry_run(), scheduled_, line);
    // An action with no effect is not an error: the run that wrote the document continued past such actions, too.
    std::erase_if(problems, [&](const io::EventProblem& problem) {
      if (problem.idle) warn(problem.place, problem.what);
      return problem.idle;
    });
  }
  if (!problems.empty()) {
    const io::EventProblem& first = problems.front();
    throw_error({first.what, format("%s:%d:%d", scenario_.path.c_str(), first.place.line, first.place.column), first.hint});
  }
  return warnings;
}

// Resumes from the state of the document's run.
void Session::resume() {
  if (!from_document_) return;
  std::vector<EventQueue::Armed> armed = simulation_.snapshot().armed;
  for (std::size_t k = 0; k < scheduled_.events.size(); ++k)
    if (const EventQueue::Armed* past = past_of(*scheduled_.events[k])) armed[k] = *past;
  simulation_.resume(armed, memory_);
}

io::Armed Session::armed() const {
  io::Armed armed = armed_at_start_;
  for (const Event& event : simulation_.events())
    if (const auto place = by_name_.find(event.name); place != by_name_.end()) ++armed[place->second].fired;
  const std::vector<EventQueue::Armed> now = simulation_.snapshot().armed;
  std::unordered_map<const io::ScenarioEvent*, const EventQueue::Armed*> scheduled;
  for (std::size_t k = 0; k < scheduled_.events.size(); ++k) scheduled.emplace(&original(*scheduled_.events[k]), &now[k]);
  for (std::size_t place = 0; place < armed.size(); ++place) {
    const auto& matches = matches_[place];
    const io::ScenarioEvent& first = *matches.front();
    if (!first.condition && first.after.empty() && first.period == 0) continue;  // its instant is sufficient
    std::vector<EventQueue::Armed> each;
    for (const io::ScenarioEvent* event : matches) {
      const auto at = scheduled.find(event);
      const EventQueue::Armed* const past = past_of(*event);
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

std::vector<io::JointKinds> Session::joints() { return io::joints_of(simulation_, simulation_.dry_run(), scenario_); }

}  // namespace momentree::cli
