#include <momentree/results/recording/topology_history.hpp>

#include <algorithm>

namespace momentree::io {

int find_body(const BodyNumbers& numbers, const Value& name) {
  const auto known = name.string() ? numbers.find(*name.string()) : numbers.end();
  return known == numbers.end() ? -1 : known->second;
}

RecordedLoop read_joint(const Value::Entry& entry, const BodyNumbers& numbers, Diagnostics& out) {
  Record joint(entry.value, "joint", out);
  RecordedLoop read{.name = entry.key, .kind = {}, .child = find_body(numbers, joint["child"])};
  if (read.child < 0) return read;
  read.kind = joint.text("kind"), read.parent = find_body(numbers, joint["parent"]);
  read.at = Record(joint["at"], "at", out).vec("xyz"), read.child_at = Record(joint["child_at"], "child_at", out).vec("xyz");
  return read;
}

TopologyHistory::TopologyHistory(Recording& run, const BodyNumbers& numbers, const std::vector<std::string>& mechanism_of)
    : run_(run), numbers_(numbers) {
  Phase phase;
  for (std::size_t b = 0; b < run.bodies.size(); ++b) {
    const bool floats = run.bodies[b].kind == "free" && run.bodies[b].parent < 0;  // nothing breaks when it is grasped
    links_[run.bodies[b].joint] = {run.bodies[b].parent, static_cast<int>(b), !floats};
    phase.mechanism.push_back(mechanism(mechanism_of[b]));
  }
  phase.joined.assign(run.bodies.size(), 1);
  for (std::size_t i = 0; i < run.loops.size(); ++i) phase.loops.push_back(static_cast<int>(i));
  run.phases = {phase};
}

int TopologyHistory::mechanism(const std::string& name) {
  const auto known = std::find(run_.mechanisms.begin(), run_.mechanisms.end(), name);
  if (known != run_.mechanisms.end()) return static_cast<int>(known - run_.mechanisms.begin());
  run_.mechanisms.push_back(name);
  return static_cast<int>(run_.mechanisms.size()) - 1;
}

void TopologyHistory::remove(const std::string& joint, RecordedEvent& event, Phase& phase) {
  if (const int opened = loop(joint, phase); opened >= 0) {
    event.opened.push_back(opened);
    std::erase(phase.loops, opened);
  }
  unlink(joint, event, phase);
}

void TopologyHistory::unlink(const std::string& joint, RecordedEvent& event, Phase& phase) {
  const auto link = links_.find(joint);
  if (link == links_.end()) return;
  if (link->second.at_start) {
    event.broken.push_back(link->second.child);
    phase.joined[static_cast<std::size_t>(link->second.child)] = 0;
  }
  links_.erase(link);
}

int TopologyHistory::loop(const std::string& name, const Phase& phase) const {
  for (const int i : phase.loops)
    if (run_.loops[static_cast<std::size_t>(i)].name == name) return i;
  return -1;
}

// True if that is all that the joint is: one that closes a loop, not the inboard joint of its child. One that has taken the place
// of a broken inboard joint stays in the picture as it was.
bool TopologyHistory::put_loop(RecordedLoop now, bool closes, RecordedEvent& event, Phase& phase) {
  const int known = loop(now.name, phase);
  if (!closes && known < 0) return false;
  if (known >= 0) {
    now.at_start = run_.loops[static_cast<std::size_t>(known)].at_start;
    if (now == run_.loops[static_cast<std::size_t>(known)]) return closes;
    std::erase(phase.loops, known);
  }
  if (now.kind == "free") {  // it holds nothing
    if (known >= 0) event.opened.push_back(known);
    return closes;
  }
  phase.loops.push_back(static_cast<int>(run_.loops.size()));
  run_.loops.push_back(std::move(now));
  return closes;
}

void TopologyHistory::put(const Value::Entry& entry, RecordedEvent& event, Phase& phase, Diagnostics& out) {
  const RecordedLoop joint = read_joint(entry, numbers_, out);
  if (joint.child < 0) return;
  const bool closes = entry.value.find("loop") != nullptr;
  if (closes) unlink(entry.key, event, phase);  // an earlier joint of that name
  if (put_loop(joint, closes, event, phase)) return;
  const auto link = links_.find(entry.key);
  const bool same = link != links_.end() && link->second.parent == joint.parent && link->second.child == joint.child;
  const bool floats = joint.kind == "free" && joint.parent < 0;
  if (same && !floats) return;
  unlink(entry.key, event, phase);
  if (!floats) links_[entry.key] = {joint.parent, joint.child, false};
}

void TopologyHistory::add(Record& line, RecordedEvent& event, Diagnostics& out) {
  Phase phase;
  phase.from = event.time;
  phase.mechanism = run_.phases.back().mechanism;
  phase.joined = run_.phases.back().joined;
  phase.loops = run_.phases.back().loops;
  event.contact = line.find("bodies") != nullptr;
  if (line.find("changes"))
    for (const Value& value : line.list("changes")) {
      Record change(value, "change", out);
      event.impacts += !change.find("skipped") && change.text("kind") == "hit";
    }
  if (const Value* value = line.find("topology")) {
    Record topology(*value, "topology", out);
    for (const Value& name : topology.list("gone"))
      if (const auto joint = read_string(name, "gone", out)) remove(*joint, event, phase);
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
