#include <momentree/io/picture/topology_history.hpp>

#include <algorithm>
#include <map>
#include <numeric>

namespace momentree::io {
namespace {

int number_of(Recording& run, const std::string& mechanism) {
  const auto known = std::find(run.mechanisms.begin(), run.mechanisms.end(), mechanism);
  if (known != run.mechanisms.end()) return static_cast<int>(known - run.mechanisms.begin());
  run.mechanisms.push_back(mechanism);
  return static_cast<int>(run.mechanisms.size()) - 1;
}

// What holds bodies together: who is joined to whom by joints of which name.
class Links {
 public:
  explicit Links(const Recording& run) : run_(run) {
    for (std::size_t b = 0; b < run.bodies.size(); ++b) {
      numbers_.emplace(run.bodies[b].name, static_cast<int>(b));
      links_[run.bodies[b].joint] = {static_cast<int>(b), run.bodies[b].parent, true};
    }
  }

  void apply(RecordedEvent& event, Phase& phase) {
    int joins = 0;
    for (const std::string& action : event.actions) joins += joined(action).empty() ? 0 : 1;
    for (const std::string& action : event.actions) {
      if (action.find(" skipped: ") != std::string::npos) continue;
      if (action.starts_with("break ")) {
        const auto broken = links_.find(action.substr(6));
        if (broken == links_.end()) continue;
        phase.gone.push_back(broken->first);
        event.about.push_back(broken->second.one);
        if (broken->second.declared) {
          event.broken.push_back(broken->second.one);
          phase.joined[static_cast<std::size_t>(broken->second.one)] = 0;
        }
        links_.erase(broken);
      } else if (const std::vector<int> pair = joined(action); !pair.empty()) {
        const std::string to = pair[1] < 0 ? "ground" : name(pair[1]);
        const bool own = joins == 1 && !event.name.empty() && event.name.front() != '#';
        const std::string joint = own ? event.name : to + "+" + name(pair[0]);
        links_[joint] = {pair[0], pair[1], false};
        phase.made.push_back({joint, pair[1], pair[0], action.starts_with("weld ")});
        event.about.push_back(pair[0]);
      } else {
        alter(action, event, phase);
      }
    }
  }

  /// By body the smallest number of a body that it is joined to.
  std::vector<int> parts() const {
    std::vector<int> part(run_.bodies.size());
    std::iota(part.begin(), part.end(), 0);
    const auto first = [&part](int b) {
      while (part[static_cast<std::size_t>(b)] != b)
        b = part[static_cast<std::size_t>(b)] = part[static_cast<std::size_t>(part[static_cast<std::size_t>(b)])];
      return b;
    };
    for (const auto& [joint, link] : links_) {
      if (link.other < 0) continue;
      const int a = first(link.one), b = first(link.other);
      part[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
    for (std::size_t b = 0; b < part.size(); ++b) part[b] = first(static_cast<int>(b));
    return part;
  }

  int number(const std::string& body) const {
    const auto known = numbers_.find(body);
    return known == numbers_.end() ? -1 : known->second;
  }

 private:
  struct Link {
    int one = -1, other = -1;
    bool declared = false;
  };
  const std::string& name(int b) const { return run_.bodies[static_cast<std::size_t>(b)].name; }

  // The bodies that an action joins, the second −1 for the ground; empty where it joins none. Names may hold " to ", too.
  std::vector<int> joined(const std::string& action) const {
    const std::size_t start = action.starts_with("weld ") ? 5 : action.starts_with("attach ") ? 7 : 0;
    for (std::size_t at = action.find(" to ", start); start > 0 && at != std::string::npos; at = action.find(" to ", at + 1)) {
      const int one = number(action.substr(start, at - start)), other = number(action.substr(at + 4));
      if (one >= 0 && (other >= 0 || action.substr(at + 4) == "ground")) return {one, other};
    }
    return {};
  }

  // What changes a joint, or hits a body, but joins and parts nothing.
  void alter(const std::string& action, RecordedEvent& event, Phase& phase) const {
    const std::size_t space = action.find(' ');
    if (space == std::string::npos) return;
    const std::string key = action.substr(0, space);
    std::string target = action.substr(space + 1);
    if (const int body = number(target); key == "impulse" && body >= 0) event.about.push_back(body);
    if (key == "change") {  // "change JOINT to KIND"
      const std::size_t to = target.rfind(" to ");
      if (to == std::string::npos) return;
      phase.changed.emplace_back(target.substr(0, to), target.substr(to + 4));
      target.resize(to);
    }
    if (key == "lock") phase.locked.push_back(target);
    if (key == "unlock") phase.unlocked.push_back(target);
    if (key == "free") phase.changed.emplace_back(target, "free");
    if (key == "hit" || key == "rest" || key == "leave") target.resize(std::min(target.size(), target.rfind(' ')));
    if (const auto link = links_.find(target); link != links_.end() && key != "impulse") event.about.push_back(link->second.one);
  }

  const Recording& run_;
  std::map<std::string, int> numbers_;
  std::map<std::string, Link> links_;
};

bool among(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// What the parts are called: new names are bodies' of theirs; else the one of their bodies' names that is still there.
void name_parts(Recording& run, const RecordedEvent& event, const Links& links, const std::vector<std::string>& roots,
                Phase& phase) {
  const std::vector<int> part = links.parts();
  std::map<int, int> mechanism;  // by part
  std::vector<std::string> taken;
  const auto take = [&](int of, const std::string& name) {
    if (mechanism.emplace(of, number_of(run, name)).second) taken.push_back(name);
  };
  for (const std::string& name : event.after.empty() ? roots : event.after)
    if (const int b = links.number(name); b >= 0 && !among(event.before, name)) take(part[static_cast<std::size_t>(b)], name);
  for (std::size_t b = 0; b < part.size(); ++b) {
    const std::string name = run.mechanisms[static_cast<std::size_t>(phase.mechanism[b])];
    if (!mechanism.contains(part[b]) && !among(taken, name) && (event.after.empty() || among(event.after, name)))
      take(part[b], name);
  }
  for (std::size_t b = 0; b < part.size(); ++b)
    if (!mechanism.contains(part[b])) take(part[b], run.bodies[b].name);
  for (std::size_t b = 0; b < part.size(); ++b) phase.mechanism[b] = mechanism.at(part[b]);
}

}  // namespace

void find_phases(Recording& run, const std::vector<std::string>& mechanism_of) {
  Phase phase;
  for (const std::string& name : mechanism_of) phase.mechanism.push_back(number_of(run, name));
  phase.joined.assign(run.bodies.size(), 1);
  run.phases = {phase};
  Links links(run);
  for (RecordedEvent& event : run.events) {
    Phase next;
    next.from = event.time;
    next.mechanism = std::move(phase.mechanism);
    next.joined = std::move(phase.joined);
    phase = std::move(next);
    const std::vector<int> before = links.parts();
    links.apply(event, phase);
    std::vector<std::string> roots;  // of what came off, where the event does not say it
    for (const int b : event.broken)
      if (run.bodies[static_cast<std::size_t>(b)].parent >= 0) roots.push_back(run.bodies[static_cast<std::size_t>(b)].name);
    if (links.parts() != before) name_parts(run, event, links, roots, phase);
    run.phases.push_back(phase);
  }
}

void correct_last_phase(Recording& run, const std::vector<std::string>& mechanism_of) {
  if (run.events.empty()) return;
  for (std::size_t b = 0; b < run.bodies.size(); ++b) run.phases.back().mechanism[b] = number_of(run, mechanism_of[b]);
}

}  // namespace momentree::io
