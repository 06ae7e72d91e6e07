#include <momentree/io/picture/phases.hpp>

#include <algorithm>

namespace momentree::io {
namespace {

int number_of(Recording& run, const std::string& mechanism) {
  const auto known = std::find(run.mechanisms.begin(), run.mechanisms.end(), mechanism);
  if (known != run.mechanisms.end()) return static_cast<int>(known - run.mechanisms.begin());
  run.mechanisms.push_back(mechanism);
  return static_cast<int>(run.mechanisms.size()) - 1;
}

/// The body whose joint an action breaks, or −1: "break chain/41", but not "break chain/41 skipped: …".
int broken_by(const Recording& run, const Phase& phase, const std::string& action) {
  if (!action.starts_with("break ")) return -1;
  const std::string joint = action.substr(6);
  for (std::size_t b = 0; b < run.bodies.size(); ++b)
    if (run.bodies[b].joint == joint && phase.joined[b]) return static_cast<int>(b);
  return -1;
}

/// The bodies outboard of `root`, itself included, along joints that hold. Parents may have any number.
std::vector<std::size_t> subtree(const Recording& run, const Phase& phase, std::size_t root) {
  std::vector<std::vector<std::size_t>> children(run.bodies.size());
  for (std::size_t b = 0; b < run.bodies.size(); ++b)
    if (run.bodies[b].parent >= 0 && phase.joined[b]) children[static_cast<std::size_t>(run.bodies[b].parent)].push_back(b);
  std::vector<std::size_t> part{root};
  for (std::size_t i = 0; i < part.size(); ++i) part.insert(part.end(), children[part[i]].begin(), children[part[i]].end());
  return part;
}

}  // namespace

void find_phases(Recording& run, const std::vector<std::string>& mechanism_of) {
  Phase phase;
  for (const std::string& name : mechanism_of) phase.mechanism.push_back(number_of(run, name));
  phase.joined.assign(run.bodies.size(), 1);
  run.phases = {phase};
  for (RecordedEvent& event : run.events) {
    phase.from = event.time;
    for (const std::string& action : event.actions) {
      const int child = broken_by(run, phase, action);
      if (child < 0) continue;
      const auto root = static_cast<std::size_t>(child);
      event.broken.push_back(child);
      phase.joined[root] = 0;
      if (run.bodies[root].parent < 0) continue;  // a mechanism whose root joint breaks keeps its name
      const int part = number_of(run, run.bodies[root].name);
      for (const std::size_t b : subtree(run, phase, root)) phase.mechanism[b] = part;
    }
    run.phases.push_back(phase);
  }
}

void correct_last_phase(Recording& run, const std::vector<std::string>& mechanism_of) {
  if (run.events.empty()) return;
  for (std::size_t b = 0; b < run.bodies.size(); ++b) run.phases.back().mechanism[b] = number_of(run, mechanism_of[b]);
}

}  // namespace momentree::io
