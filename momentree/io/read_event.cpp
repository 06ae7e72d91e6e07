// [[event]]: an instant and what breaks at it. Names are complete; `*` matches within a name, one event armed for each match.
#include <algorithm>

#include <momentree/io/scenario_parts.hpp>

namespace momentree::io {

namespace {

constexpr std::size_t most_events = 1'000'000;

// `*` stands for any run of characters but '/'. Two positions to go back to at most: linear in practice, never recursive.
bool matches(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, star_n = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++, star_n = n;
    } else if (p < pattern.size() && pattern[p] == name[n]) {
      ++p, ++n;
    } else if (star != std::string_view::npos && name[star_n] != '/') {
      p = star + 1, n = ++star_n;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

std::string mechanism_of(const std::string& name) { return name.substr(0, name.find('/')); }

void report_unknown(const std::string& target, Place place, Reading& reading) {
  if (reading.opaque.contains(mechanism_of(target))) return;
  std::string hint;
  for (const auto& [joint, body] : reading.body_of_joint)
    if (body == target) hint = "the joint of that body is " + in_quotes(joint);
  if (hint.empty() && target.find('/') == std::string::npos)
    for (const auto& [mechanism, where] : reading.mechanisms)
      if (reading.joints.contains(mechanism + "/" + target)) hint = "names are complete: " + in_quotes(mechanism + "/" + target);
  if (hint.empty()) hint = reading.suggest(target, reading.joints);
  reading.out.error(place, "break: there is no joint " + in_quotes(target), std::move(hint));
}

// The joints that a name with wildcards stands for, in the order of the model.
std::vector<std::string> matching(const std::string& pattern, Reading& reading) {
  const std::string_view literal = std::string_view(pattern).substr(0, pattern.find('*'));
  std::vector<std::string> found;
  auto at = std::lower_bound(reading.sorted_joints.begin(), reading.sorted_joints.end(), literal);
  for (; at != reading.sorted_joints.end() && at->substr(0, literal.size()) == literal; ++at)
    if (matches(pattern, *at)) found.emplace_back(*at);
  const Model& model = reading.scenario.model;
  const auto number = [&](const std::string& joint) { return model.has_joint(joint) ? model.joint(joint).index : -1; };
  std::vector<std::pair<int, std::string>> numbered;
  for (std::string& joint : found) numbered.emplace_back(number(joint), std::move(joint));
  std::sort(numbered.begin(), numbered.end());
  found.clear();
  for (auto& [index, joint] : numbered) found.push_back(std::move(joint));
  return found;
}

void sort_joints(Reading& reading) {
  if (!reading.sorted_joints.empty()) return;
  for (const auto& [name, place] : reading.joints) reading.sorted_joints.push_back(name);
  std::sort(reading.sorted_joints.begin(), reading.sorted_joints.end());
}

void read_breaks(const Value& value, ScenarioEvent event, Reading& reading) {
  Diagnostics& out = reading.out;
  const Value::Array single{value};
  const Value::Array& targets = value.array() ? *value.array() : single;
  if (targets.empty()) out.error(value.place, "break: names no joint");
  ScenarioEvent plain = event;
  std::vector<ScenarioEvent> wild;
  for (const Value& target : targets) {
    const auto name = read_string(target, "break", out);
    if (!name) continue;
    if (name->find('*') != std::string::npos) {
      sort_joints(reading);
      const std::vector<std::string> joints = matching(*name, reading);
      if (joints.empty() && !reading.opaque.contains(mechanism_of(*name)))
        out.error(target.place, "break: no joint matches " + in_quotes(*name), "* matches within a name: \"chain/*\"");
      for (const std::string& joint : joints) {
        reading.broken.emplace(joint, target.place);
        wild.push_back(event);
        wild.back().actions.push_back(break_joint(joint));
        if (reading.scenario.events.size() + wild.size() <= most_events) continue;
        out.error(target.place, "more than 1000000 events");
        return;
      }
    } else if (!reading.joints.contains(*name)) {
      report_unknown(*name, target.place, reading);
    } else {
      const auto [first, fresh] = reading.broken.emplace(*name, target.place);
      if (!fresh)
        out.error(target.place, "break: joint " + in_quotes(*name) + " is broken already on " + out.name_of(first->second),
                  "a joint breaks once");
      plain.actions.push_back(break_joint(*name));
    }
  }
  if (!plain.actions.empty()) reading.scenario.events.push_back(std::move(plain));
  for (ScenarioEvent& each : wild) reading.scenario.events.push_back(std::move(each));
}

}  // namespace

void read_event(const Value& table, int number, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, "[[event]]", out);
  ScenarioEvent event;
  event.place = fields.place();
  event.name = "#" + std::to_string(number);
  if (const auto name = fields.string("name"); name && check_bare_name(*name, fields.place_of("name"), "an event", out)) {
    event.name = *name;
    reading.note(reading.events, *name, fields.place_of("name"), "event");
  }
  if (const auto at = fields.not_negative("at", dimension::time)) event.time = *at;
  const Value* broken = fields.find("break");
  const bool other_trigger = fields.later({"when", "after", "every"}, "this version has events at an instant: at = \"1.8 s\"");
  fields.later({"from", "repeat", "hysteresis", "for", "locate"});
  const bool other_action = fields.later({"free", "change", "lock", "unlock", "weld", "attach", "impulse", "set"},
                                         "this version has break = \"mechanism/joint\"");
  if (!fields.has("at") && !other_trigger)
    out.error(fields.place(), "event " + in_quotes(event.name) + " has no instant", "for example at = \"1.8 s\"");
  if (!broken && !other_action)
    out.error(fields.place(), "event " + in_quotes(event.name) + " does nothing", "for example break = \"chain/41\"");
  if (broken) read_breaks(*broken, std::move(event), reading);
  fields.finish();
}

void check_events(Reading& reading) {
  if (reading.broken.empty()) return;
  const Model& model = reading.scenario.model;
  Diagnostics& out = reading.out;
  // The part that comes off hangs on a joint named after its root body: that name must not be another joint's.
  for (const auto& [joint, place] : reading.broken) {
    const std::string& body = model[model.joint(joint)].name;
    if (body != joint && model.has_joint(body))
      out.error(place,
                "break: the part that comes off would hang on a joint named " + in_quotes(body) +
                    " after its body, but another joint has that name",
                "give one of them another name");
  }
  // With every break done the parts are the smallest that there will be: a freedom that still moves mass then always does.
  Model apart(Model::Options{model.gravity()});
  std::vector<Place> place_of_body;
  for (const BodySpec& body : model.bodies()) {
    BodySpec spec = body;
    const auto broken = reading.broken.find(spec.joint_name);
    place_of_body.push_back(broken == reading.broken.end() ? Place{} : broken->second);
    if (broken != reading.broken.end()) {
      spec.parent = ground;
      spec.at = spec.child_at = Pose{};
      spec.joint = JointSpec{};
      spec.joint.kind = Kind::free;
      spec.q = spec.v = Values{};
    }
    apart.add_unjudged(std::move(spec));
  }
  for (const SingularJoint& singular : singular_joints(apart)) {
    const Place place = place_of_body[static_cast<std::size_t>(singular.body.index)];
    const std::string joint = in_quotes(apart[singular.body].joint_name);
    if (place.line > 0 || place.option > 0)
      out.error(place, "break: the part that comes off at " + joint + " has not the mass or inertia to move freely",
                "give it a mass and an inertia about every axis");
    else
      out.error(reading.broken.begin()->second, "break: joint " + joint + " would no longer move any mass", singular.hint);
  }
}

}  // namespace momentree::io
