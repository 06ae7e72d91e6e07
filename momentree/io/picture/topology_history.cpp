#include <momentree/io/picture/topology_history.hpp>

#include <algorithm>

namespace momentree::io {
namespace {

const JsonNode& required(const JsonDocument& line, const JsonNode& node, const char* key) {
  const JsonNode* const found = node.find(key);
  if (found == nullptr) line.fail_at(node, '`' + std::string(key) + "` is missing");
  return *found;
}

}  // namespace

TopologyHistory::TopologyHistory(Recording& run, const std::vector<std::string>& mechanism_of) : run_(run) {
  Phase phase;
  for (std::size_t b = 0; b < run.bodies.size(); ++b) {
    bodies_.emplace(run.bodies[b].name, static_cast<int>(b));
    const bool floats = run.bodies[b].kind == "free" && run.bodies[b].parent < 0;  // nothing breaks when it is grasped
    links_[run.bodies[b].joint] = {run.bodies[b].parent, static_cast<int>(b), !floats};
    phase.mechanism.push_back(mechanism(mechanism_of[b]));
  }
  phase.joined.assign(run.bodies.size(), 1);
  run.phases = {phase};
}

int TopologyHistory::mechanism(const std::string& name) {
  const auto known = std::find(run_.mechanisms.begin(), run_.mechanisms.end(), name);
  if (known != run_.mechanisms.end()) return static_cast<int>(known - run_.mechanisms.begin());
  run_.mechanisms.push_back(name);
  return static_cast<int>(run_.mechanisms.size()) - 1;
}

int TopologyHistory::body(const JsonDocument& line, const JsonNode& name) const {
  if (name.is(JsonNode::Type::null)) return -1;
  const auto known = bodies_.find(line.string(name, "the name of a body"));
  return known == bodies_.end() ? -1 : known->second;
}

void TopologyHistory::remove(const std::string& joint, RecordedEvent& event, Phase& phase) {
  const auto link = links_.find(joint);
  if (link == links_.end()) return;
  if (link->second.at_start) {
    event.broken.push_back(link->second.child);
    phase.joined[static_cast<std::size_t>(link->second.child)] = 0;
  }
  links_.erase(link);
}

void TopologyHistory::put(const JsonDocument& line, const std::string& name, const JsonNode& joint, RecordedEvent& event,
                          Phase& phase) {
  const int parent = body(line, member(line, joint, "parent")), child = body(line, member(line, joint, "child"));
  if (child < 0) return;
  const auto link = links_.find(name);
  const bool same = link != links_.end() && link->second.parent == parent && link->second.child == child;
  const bool floats = line.string(member(line, joint, "kind"), "`kind`") == "free" && parent < 0;
  if (same && !floats) return;
  remove(name, event, phase);
  if (!floats) links_[name] = {parent, child, false};
}

void TopologyHistory::add(const JsonDocument& line, RecordedEvent& event) {
  Phase phase;
  phase.from = event.time;
  phase.mechanism = run_.phases.back().mechanism;
  phase.joined = run_.phases.back().joined;
  if (const JsonNode* changes = line.root.find("changes"))
    for (const JsonNode& change : line.array(*changes, "`changes`").items)
      event.impacts += change.find("skipped") == nullptr && member(line, change, "kind").text == "hit";
  if (const JsonNode* topology = line.root.find("topology")) {
    for (const JsonNode& name : line.array(member(line, *topology, "gone"), "`gone`").items)
      remove(line.string(name, "the name of a joint"), event, phase);
    for (const auto& [name, joint] : line.object(member(line, *topology, "joints"), "`joints`").members)
      put(line, name, joint, event, phase);
    for (const auto& [name, ranges] : line.object(required(line, *topology, "moved"), "`moved`").members) {
      const int number = mechanism(name);
      for (const JsonNode& range : line.array(ranges, "ranges of bodies").items) {
        if (line.array(range, "a range").items.size() != 2) line.fail_at(range, "a range consists of its first body and a count");
        const double first = line.number(range.items[0], "a body"), count = line.number(range.items[1], "a number of bodies");
        const auto size = static_cast<double>(phase.mechanism.size());
        if (!(first >= 0 && count >= 0 && first + count <= size)) line.fail_at(range, "there are no such bodies");
        std::fill_n(phase.mechanism.begin() + static_cast<long>(first), static_cast<long>(count), number);
      }
    }
  }
  run_.phases.push_back(std::move(phase));
}

}  // namespace momentree::io
