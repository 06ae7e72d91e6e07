#include <cli/session.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

#include <cli/text.hpp>
#include <momentree/io/text_file.hpp>

namespace momentree::cli {

std::optional<io::Scenario> load(const std::string& path, const std::vector<std::string>& overrides) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  for (const char* model : {".urdf", ".sdf", ".xml", ".mjcf"})
    if (ending == model) fail({"model files (" + ending + ") are not supported yet", path, "write a scenario file (.toml)"});
  io::ReadResult result = io::read_scenario(path, overrides);
  std::fputs(io::rendered(result.diagnostics).c_str(), stderr);
  return std::move(result.scenario);
}

Session::Session(const io::Scenario& scenario, const std::string& state)
    : scenario_(scenario), simulation_(scenario.model, scenario.integration) {
  for (const io::ScenarioEvent& event : scenario.events) {
    const auto known = [&](const auto& entry) { return entry.first == event.name; };
    if (std::ranges::none_of(armed_at_start_, known)) armed_at_start_.emplace_back(event.name, 0);
  }

  std::vector<io::RestoredState> documents;
  if (state.empty())
    for (const io::StateFile& file : scenario.state_files) read(file.file, file.mechanism, documents);
  else
    read(state, "", documents);
  if (documents.empty()) return;
  from_document_ = true;
  io::restore(simulation_, documents);
  for (const io::RestoredState& document : documents)
    for (const auto& [name, fired] : document.armed) {
      const auto entry = std::ranges::find(armed_at_start_, name, &std::pair<std::string, int>::first);
      if (entry != armed_at_start_.end()) {
        entry->second = fired;
        continue;
      }
      std::vector<std::string> names;
      for (const auto& known : armed_at_start_) names.push_back(known.first);
      fail({"`armed` names an unknown event '" + name + "'", document.file, did_you_mean(name, names)});
    }
}

void Session::read(const std::string& file, const std::string& mechanism, std::vector<io::RestoredState>& documents) const {
  documents.push_back(io::read_state(io::read_text_file(file), file, scenario_.model, mechanism));
}

void Session::schedule() {
  const double start = simulation_.time();
  std::vector<const io::ScenarioEvent*> events;
  for (const io::ScenarioEvent& event : scenario_.events) {
    const bool fired = std::ranges::find(armed_at_start_, event.name, &std::pair<std::string, int>::first)->second > 0;
    const bool once = !(event.condition && event.condition->repeats) && event.after.empty() && event.period == 0;
    if (event.condition && fired && once) continue;
    if (event.period == 0 && (event.time < start || (event.time == start && fired))) {
      if (!fired)
        std::fprintf(stderr, "%s:%d: warning: event '%s' at %g s does not happen: the run starts at %g s\n",
                     scenario_.path.c_str(), event.place.line, event.name.c_str(), event.time, start);
      continue;
    }
    events.push_back(&event);
  }
  const io::Schedule scheduled = io::schedule(simulation_, std::move(events));
  std::vector<io::EventProblem> problems = scheduled.problems;
  if (problems.empty() && from_document_) {  // else the reader has tried them
    const auto line = [](Place place) { return format("line %d", place.line); };
    problems = io::problems_of(simulation_.rehearse(), scheduled, line);
  }
  if (problems.empty()) return;
  const io::EventProblem& first = problems.front();
  fail({first.what, format("%s:%d:%d", scenario_.path.c_str(), first.place.line, first.place.column), first.hint});
}

io::Armed Session::armed() const {
  io::Armed armed = armed_at_start_;
  for (const Event& event : simulation_.events()) {
    const auto entry = std::ranges::find(armed, event.name, &std::pair<std::string, int>::first);
    if (entry != armed.end()) ++entry->second;
  }
  return armed;
}

std::vector<io::JointKinds> Session::joints() { return io::joints_of(simulation_, simulation_.rehearse(), scenario_); }

}  // namespace momentree::cli
