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
  for (const io::ScenarioEvent& event : scenario_.events) {
    const bool fired = std::ranges::find(armed_at_start_, event.name, &std::pair<std::string, int>::first)->second > 0;
    if (event.time < start || (event.time == start && fired)) {
      if (!fired)
        std::fprintf(stderr, "%s:%d: warning: event '%s' at %g s does not happen: the run starts at %g s\n",
                     scenario_.path.c_str(), event.place.line, event.name.c_str(), event.time, start);
      continue;
    }
    Simulation::Scheduled scheduled = simulation_.at(event.time);
    scheduled.named(event.name);
    for (const Action& action : event.actions) scheduled.then(action);
  }
}

io::Armed Session::armed() const {
  io::Armed armed = armed_at_start_;
  for (const Event& event : simulation_.events()) {
    const auto entry = std::ranges::find(armed, event.name, &std::pair<std::string, int>::first);
    if (entry != armed.end()) ++entry->second;
  }
  return armed;
}

std::vector<Body> Session::breakable() const {
  std::vector<Body> bodies;
  const World& world = simulation_.world();
  for (const io::ScenarioEvent& event : scenario_.events)
    for (const Action& action : event.actions)
      for (const std::string& joint : action->joints()) bodies.push_back(world.model().joint(joint));
  for (int b = 0; b < world.model().size(); ++b)
    if (world.tree().detached(b)) bodies.push_back({b});
  return bodies;
}

}  // namespace momentree::cli
