#include <momentree/io/picture/topology_history.hpp>

#include <algorithm>

namespace momentree::io {
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

int TopologyHistory::body(const Value& name) const {
  const auto known = name.string() ? bodies_.find(*name.string()) : bodies_.end();
  return known == bodies_.end() ? -1 : known->second;
}

void TopologyHistory::note_changes(Record& line, RecordedEvent& event, Diagnostics& out) const {
  if (!line.find("changes")) return;
  for (const Value& value : line.list("changes")) {
    Record change(value, "change", out);
    if (change.find("skipped")) continue;
    event.hits += change.text("kind") == "hit";
    if (const Value* name = change.find("body")) {
      if (const int b = body(*name); b >= 0) event.about.push_back(b);
    } else if (change.find("joint")) {
      if (const auto link = links_.find(change.text("joint")); link != links_.end()) event.about.push_back(link->second.child);
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

void TopologyHistory::put(const Value::Entry& entry, RecordedEvent& event, Phase& phase, Diagnostics& out) {
  Record joint(entry.value, "joint", out);
  RecordedJoint now;
  now.name = entry.key;
  now.kind = joint.text("kind");
  now.parent = body(joint["parent"]);
  now.child = body(joint["child"]);
  now.at = Record(joint["at"], "at", out).vec("xyz");
  now.child_at = Record(joint["child_at"], "child_at", out).vec("xyz");
  if (const Value* locked = joint.find("locked")) now.locked = locked->boolean() && *locked->boolean();
  if (now.child < 0) return;
  const auto link = links_.find(now.name);
  const bool same = link != links_.end() && link->second.parent == now.parent && link->second.child == now.child;
  if (const bool floats = now.kind == "free" && now.parent < 0; !same || floats) {
    remove(now.name, event, phase);
    if (!floats) links_[now.name] = {now.parent, now.child, false};
  }
  phase.joints.push_back(std::move(now));
}

void TopologyHistory::add(Record& line, RecordedEvent& event, Diagnostics& out) {
  Phase phase;
  phase.from = event.time;
  phase.mechanism = run_.phases.back().mechanism;
  phase.joined = run_.phases.back().joined;
  note_changes(line, event, out);
  if (const Value* value = line.find("topology")) {
    Record topology(*value, "topology", out);
    for (const Value& name : topology.list("gone")) {
      phase.gone.push_back(name.string() ? *name.string() : "");
      remove(phase.gone.back(), event, phase);
    }
    for (const Value::Entry& joint : topology.table("joints")) put(joint, event, phase, out);
    for (const Value::Entry& moved : topology.table("moved")) {
      const int number = mechanism(moved.key);
      for (const Value& range : read_list(moved.value, "moved", out)) {
        const std::vector<double> bodies = read_reals(range, 2, "moved", out);  // the first one and their number
        if (bodies.empty()) continue;
        const auto size = static_cast<double>(phase.mechanism.size());
        if (bodies[0] >= 0 && bodies[1] >= 0 && bodies[0] + bodies[1] <= size)
          std::fill_n(phase.mechanism.begin() + static_cast<long>(bodies[0]), static_cast<long>(bodies[1]), number);
        else
          out.error(range.place, "moved: there are no such bodies", damaged);
      }
    }
  }
  run_.phases.push_back(std::move(phase));
}

}  // namespace momentree::io
