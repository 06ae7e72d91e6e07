// Determines which joints the events of a scenario make and their kinds over time, and reports joint names that refer to
// nothing.
#include <algorithm>
#include <cmath>

#include <momentree/base/check.hpp>
#include <momentree/scenario/events/argument_reader.hpp>
#include <momentree/scenario/keys/joint_tables.hpp>
#include <momentree/simulate/events/instant.hpp>

namespace momentree::io {

namespace {

struct Became {
  double time;
  Kind kind;
};

// The kind of joint whose parameters have the units of those of a spring: with one length as its coordinate.
const KindInfo& spring_parameters() {
  for (const KindInfo& kind : all_kinds())
    if (kind.nv == 1 && kind.v_units[0] == 'm') return kind;
  MT_REQUIRE(false, "a kind of joint has one length as its coordinate");
  return all_kinds().front();
}

class Names {
 public:
  explicit Names(Reading& reading) : reading_(reading), model_(reading.scenario.model) {
    for (const ScenarioEvent& event : reading.scenario.events) {
      for (std::size_t a = 0; a < event.actions.size(); ++a) {
        const ActionBase& action = *event.actions[a];
        const std::optional<Kind> kind = action.resulting_kind();
        if (const std::string name = made_joint_name({event.name, event.named, event.actions}, a); !name.empty()) {
          MT_REQUIRE(kind.has_value(), "an action that makes a joint gives its kind");
          reading.made.emplace(name, event.places[a]);
          became_[name].push_back({event.time, *kind});
          joins_ = true;
        } else if (kind) {
          for (const std::string& joint : action.joints()) became_[joint].push_back({event.time, *kind});
        } else if (action.effect() == JointEffect::removed) {
          for (const std::string& joint : action.joints()) broken(joint, event.time);
        }
      }
    }
    for (auto& [name, kinds] : became_)
      std::stable_sort(kinds.begin(), kinds.end(), [](const Became& a, const Became& b) { return a.time < b.time; });
  }

  bool known(const std::string& joint) const {
    if (reading_.joints.contains(joint) || reading_.made.contains(joint) || became_free_.contains(joint)) return true;
    if (reading_.opaque.contains(mechanism_of(joint))) return true;
    // a document may contain other joints: names are then checked when it is read
    const auto& files = reading_.scenario.state_files;
    if (std::any_of(files.begin(), files.end(), [](const StateFile& file) { return file.mechanism.empty(); })) return true;
    // The name of a re-rooted part is known only in the run.
    const std::size_t tail = joint.rfind("~free");
    return joins_ && !became_free_.empty() && reading_.bodies.contains(joint.substr(0, tail));
  }

  /// The joint is made only after that instant, or at it by an action that comes later.
  bool still_to_come(const Reading::JointUse& use) const {
    if (!reading_.made.contains(use.name) || reading_.joints.contains(use.name)) return false;
    const double first = became_.at(use.name).front().time;
    if (!std::isfinite(first)) return false;  // by an event whose instant is unknown
    return first > use.time || (first == use.time && !use.of_parameters);
  }

  /// The kind of the joint at that time, as far as the file determines it; null otherwise.
  const KindInfo* kind_of(const std::string& joint, double time) const {
    if (model_.has_spring(joint)) return &spring_parameters();
    const KindInfo* kind = model_.has_joint(joint) ? &info(model_.joint_spec(model_.joint(joint)).kind) : nullptr;
    const auto found = became_.find(joint);
    if (found == became_.end()) return kind;
    for (const Became& each : found->second)
      if (each.time <= time) kind = &info(each.kind);
    return kind;
  }

  /// The same for an event whose instant may be unknown: the joint may then have any of its kinds.
  std::vector<const KindInfo*> kinds_of(const std::string& joint, double time) const {
    const auto found = became_.find(joint);
    const double when = std::isfinite(time) || found == became_.end() ? time : -HUGE_VAL;
    std::vector<const KindInfo*> kinds;
    const auto add = [&](const KindInfo* kind) {
      if (kind != nullptr && std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(kind);
    };
    add(kind_of(joint, when));
    if (when != time)
      for (const Became& each : found->second) add(&info(each.kind));
    return kinds;
  }

 private:
  // The free joint of a separated part is named after its body.
  void broken(const std::string& joint, double time) {
    if (!model_.has_joint(joint) || is_loop(model_.joint(joint))) return;
    const BodyId child = model_.child(model_.joint(joint));
    const std::string& body = model_[child].name;
    const std::string name = body == joint || !model_.has_joint(body) ? body : body + "~free";
    became_free_.insert(name);
    became_[name].push_back({time, Kind::free});
  }

  Reading& reading_;
  const Model& model_;
  std::unordered_map<std::string, std::vector<Became>> became_;
  std::unordered_set<std::string> became_free_;
  bool joins_ = false;
};

// Actions that set parameters of joints, with a wildcard: each matching joint gets the values that its kind can have.
class WildSets {
 public:
  WildSets(const Names& names, Reading& reading) : names_(names) {
    std::unordered_map<const Value*, std::vector<Kind>> kinds;
    std::vector<const Reading::LateEntry*> order;
    for (const Reading::LateEntry& late : reading.late) {
      const KindInfo* kind = kind_of(late);
      if (!kind) continue;
      std::vector<Kind>& met = kinds[late.value];
      if (met.empty()) order.push_back(&late);
      if (std::find(met.begin(), met.end(), kind->kind) == met.end()) met.push_back(kind->kind);
    }
    for (const Reading::LateEntry* late : order) {
      const Value* value = late->value;
      const std::string key(late->action->key());
      Fields fields(*value, key, reading.out);
      const Value* name = fields.find("joint");
      JointTable table(fields, value->place, false, name && name->string() ? *name->string() : "", key);
      fields.finish();
      if (table.empty()) reading.out.error(value->place, key + ": changes nothing", late->action->hint());
      table.read(kinds[value], reading.out);
      table.check(reading.out);
      tables_.emplace(value, std::move(table));
    }
  }

  /// True if the entry has a wildcard, and the action is filled in or has nothing to do.
  bool fill(const Reading::LateEntry& late) {
    const KindInfo* kind = kind_of(late);
    if (!kind) return false;
    const JointTable::Part* part = tables_.at(late.value).part(kind->kind);
    const JointParameters none;
    late.action->arguments([&](const Argument& each) {
      if (const auto* joint = each.as<argument::Joint>()) joint->name = late.match;
      if (const auto* parameters = each.as<argument::Parameters>())
        parameters->values = part != nullptr ? part->parameters : none;
    });
    if (part == nullptr) idle_.insert(late.action.get());
    return true;
  }

  /// Removes actions that have nothing to do from their events.
  void drop_idle(std::vector<ScenarioEvent>& events) const {
    if (idle_.empty()) return;
    for (ScenarioEvent& event : events) {
      std::vector<Action> actions;
      std::vector<Place> places;
      for (std::size_t a = 0; a < event.actions.size(); ++a) {
        if (idle_.contains(&*event.actions[a])) continue;
        actions.push_back(event.actions[a]);
        places.push_back(event.places[a]);
      }
      event.actions = std::move(actions), event.places = std::move(places);
    }
    std::erase_if(events, [](const ScenarioEvent& event) { return event.actions.empty(); });
  }

 private:
  const KindInfo* kind_of(const Reading::LateEntry& late) const {
    return late.match.empty() || !late.value->table() ? nullptr : names_.kind_of(late.match, late.time);
  }

  const Names& names_;
  std::unordered_map<const Value*, JointTable> tables_;
  std::unordered_set<const ActionBase*> idle_;
};

// The joints that an event makes, or all events if its name is empty.
std::string joints_made_by(const std::string& name, const Reading& reading) {
  constexpr int shown = 3;
  int count = 0;
  std::string names;
  for (const ScenarioEvent& event : reading.scenario.events)
    for (std::size_t a = 0; a < event.actions.size(); ++a) {
      const std::string joint = made_joint_name({event.name, event.named, event.actions}, a);
      if (joint.empty() || (!name.empty() && event.name != name)) continue;
      if (++count <= shown) names += (names.empty() ? "" : ", ") + in_quotes(joint);
    }
  const std::string by = name.empty() ? "events make the joint" : "the event of that name makes the joint";
  if (count == 0) return "the event of that name makes no joint";
  return by + (count > 1 ? "s " : " ") + names + (count > shown ? " and " + std::to_string(count - shown) + " more" : "");
}

void report_unknown(const Reading::JointUse& use, Reading& reading) {
  const std::string& target = use.name;
  std::string hint;
  for (const auto& [joint, body] : reading.body_of_joint)
    if (body == target) hint = "the joint of that body is " + in_quotes(joint);
  if (hint.empty() && target.find('/') == std::string::npos)
    for (const auto& [mechanism, where] : reading.mechanisms)
      if (reading.joints.contains(mechanism + "/" + target)) hint = "use the full name: " + in_quotes(mechanism + "/" + target);
  if (hint.empty() && reading.events.contains(target)) hint = joints_made_by(target, reading);
  if (hint.empty()) hint = reading.suggest(target, reading.made);
  if (hint.empty()) hint = reading.suggest(target, reading.joints);
  const bool springs = use.springs_too && !reading.springs.empty();
  if (hint.empty() && springs) hint = reading.suggest(target, reading.springs);
  if (hint.empty() && !reading.made.empty()) hint = joints_made_by("", reading);
  reading.out.error(use.place, use.key + ": there is no joint " + (springs ? "or spring " : "") + in_quotes(target),
                    std::move(hint));
}

// The joint or spring of an action is in a mechanism that could not be read: what kind it has is unknown.
bool is_unread(const Value& action, const Reading& reading) {
  const Value::Entry* const entry = action.find("joint");
  const std::string* const joint = entry != nullptr ? entry->value.string() : nullptr;
  return joint != nullptr && reading.opaque.contains(mechanism_of(*joint)) && !reading.joints.contains(*joint);
}

}  // namespace

void finish_events(Reading& reading) {
  if (reading.joint_uses.empty() && reading.late.empty()) return;
  const Names names(reading);
  WildSets wild(names, reading);
  const Value* wrong = nullptr;  // an error in one table concerns every match of its wildcard
  for (const Reading::LateEntry& late : reading.late) {
    if (late.value == wrong || is_unread(*late.value, reading) || wild.fill(late)) continue;
    ArgumentReader reader(*late.value, *late.action, {"", late.match, late.match}, late.time, reading);
    reader.kinds_of = [&](const std::string& joint) { return names.kinds_of(joint, late.time); };
    if (!reader.read()) wrong = late.value;
  }
  wild.drop_idle(reading.scenario.events);
  for (const Reading::JointUse& use : reading.joint_uses)
    if (reading.springs.contains(use.name)) {
      if (!use.springs_too)
        reading.out.error(use.place, use.key + ": " + in_quotes(use.name) + " is a spring, not a joint",
                          "a spring can break and be set, and has a reaction_force");
    } else if (!names.known(use.name))
      report_unknown(use, reading);
    else if (names.still_to_come(use))
      reading.out.error(use.place, use.key + ": joint " + in_quotes(use.name) + " does not exist yet: it is made later, on " +
                                       reading.out.name_of(reading.made.at(use.name)));
}

}  // namespace momentree::io
