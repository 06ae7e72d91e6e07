#include <momentree/io/picture/topology_history.hpp>

#include <algorithm>

namespace momentree::io {
namespace {

const JsonNode& required(const JsonDocument& line, const JsonNode& node, const char* key) {
  const JsonNode* const found = node.find(key);
  if (found == nullptr) line.fail_at(node, '`' + std::string(key) + "` is missing");
  return *found;
}

Vec3 origin(const JsonDocument& line, const JsonNode& pose) {
  const JsonNode& xyz = required(line, pose, "xyz");
  if (line.array(xyz, "`xyz`").items.size() != 3) line.fail_at(xyz, "`xyz` should have three numbers");
  return {line.number(xyz.items[0], "x"), line.number(xyz.items[1], "y"), line.number(xyz.items[2], "z")};
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

void TopologyHistory::note_changes(const JsonDocument& line, RecordedEvent& event) const {
  const JsonNode* const changes = line.root.find("changes");
  if (changes == nullptr) return;
  for (const JsonNode& change : line.array(*changes, "`changes`").items) {
    if (change.find("skipped") != nullptr) continue;
    event.hits += required(line, change, "kind").text == "hit";
    if (const JsonNode* name = change.find("body")) {
      if (const int b = body(line, *name); b >= 0) event.about.push_back(b);
    } else if (const JsonNode* joint = change.find("joint")) {
      if (const auto link = links_.find(joint->text); link != links_.end()) event.about.push_back(link->second.child);
    }
  }
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
  RecordedJoint now;
  now.name = name;
  now.kind = line.string(required(line, joint, "kind"), "`kind`");
  now.parent = body(line, required(line, joint, "parent"));
  now.child = body(line, required(line, joint, "child"));
  now.at = origin(line, required(line, joint, "at"));
  now.child_at = origin(line, required(line, joint, "child_at"));
  if (const JsonNode* locked = joint.find("locked")) now.locked = locked->is(JsonNode::Type::boolean) && locked->number == 1;
  if (now.child < 0) return;
  const auto link = links_.find(name);
  const bool same = link != links_.end() && link->second.parent == now.parent && link->second.child == now.child;
  if (const bool floats = now.kind == "free" && now.parent < 0; !same || floats) {
    remove(name, event, phase);
    if (!floats) links_[name] = {now.parent, now.child, false};
  }
  phase.joints.push_back(std::move(now));
}

void TopologyHistory::add(const JsonDocument& line, RecordedEvent& event) {
  Phase phase;
  phase.from = event.time;
  phase.mechanism = run_.phases.back().mechanism;
  phase.joined = run_.phases.back().joined;
  note_changes(line, event);
  if (const JsonNode* topology = line.root.find("topology")) {
    for (const JsonNode& name : line.array(required(line, *topology, "gone"), "`gone`").items) {
      phase.gone.push_back(line.string(name, "the name of a joint"));
      remove(phase.gone.back(), event, phase);
    }
    for (const auto& [name, joint] : line.object(required(line, *topology, "joints"), "`joints`").members)
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
