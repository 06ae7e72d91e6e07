// One entry of an event's actions: a name, or a table with the fields that the action needs.
#include <momentree/scenario/events/argument_reader.hpp>

namespace momentree::io {

namespace {

// The name in an entry that may contain a wildcard: that of the joint or body that it acts on.
const Value* wild_name(const Value& entry) {
  const Value* name = &entry;
  for (const char* key : {"joint", "body"})
    if (const Value::Entry* found = entry.find(key)) name = &found->value;
  return name->string() && name->string()->find('*') != std::string::npos ? name : nullptr;
}

}  // namespace

std::string mechanism_of(const std::string& name) { return name.substr(0, name.find('/')); }

const std::vector<std::string>& scenario_actions() {
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> all = action_keys();
    std::erase_if(all, [](const std::string& key) { return !make_action(key)->in_scenarios(); });
    return all;
  }();
  return keys;
}

bool sets_parameters(WithArguments& action) {
  bool found = false;
  action.arguments([&found](const Argument& each) { found = found || each.as<argument::Parameters>() != nullptr; });
  return found;
}

void read_actions(const Value& value, const std::string& key, ScenarioEvent& event, const TriggerMatch* trigger,
                  std::vector<ScenarioEvent>& wild, Reading& reading) {
  Diagnostics& out = reading.out;
  const Value::Array single = value.array() ? Value::Array{} : Value::Array{value};
  const Value::Array& entries = value.array() ? *value.array() : single;
  const std::shared_ptr<ActionBase> any = make_action(key);
  const bool late = sets_parameters(*any);
  const std::string plain = any->plain_argument() ? any->plain_argument() : "";
  if (entries.empty()) out.error(value.place, key + (plain.empty() ? ": an empty list does nothing" : ": names no " + plain));
  // At a known instant each match becomes a separate event; otherwise all matches happen together with the event.
  const bool together = trigger != nullptr || event.condition || !event.after.empty() || event.period > 0;
  const auto add = [&](const Value& entry, const std::string& match, ScenarioEvent& to) {
    if (--reading.actions_left < 0) {
      if (reading.actions_left == -1)
        out.error(entry.place, "more than 1000000 actions", "a wildcard counts once for each name that it matches");
      return false;
    }
    const std::shared_ptr<ActionBase> action = make_action(key);
    if (late)  // the units depend on a joint that another event may make
      reading.late.push_back({action, value.array() ? &entry : &value, match, event.time});
    else if (!ArgumentReader(entry, *action, {"", match, match}, event.time, reading).read())
      return false;
    to.actions.emplace_back(std::shared_ptr<const ActionBase>(action));
    to.places.push_back(entry.place);
    return true;
  };
  for (const Value& entry : entries) {
    const Value* pattern = wild_name(entry);
    if (!pattern) {
      add(entry, "", event);
      continue;
    }
    const bool bodies = entry.table() ? entry.find("body") != nullptr : plain == "body";
    const std::string& name = *pattern->string();
    if (trigger && name == trigger->pattern) {
      add(entry, bodies ? trigger->body : trigger->joint, event);
      continue;
    }
    const std::vector<std::string> found =
        bodies ? matching_bodies(name, reading) : matching_joints(name, any->takes_springs(), reading);
    if (found.empty() && !reading.opaque.contains(mechanism_of(name)))
      out.error(pattern->place, key + ": no " + (bodies ? "body" : "joint") + " matches " + in_quotes(name),
                "* matches within a name: \"chain/*\"");
    for (const std::string& match : found) {
      if (together) {
        event.wild = true;
        if (!add(entry, match, event)) break;
        continue;
      }
      ScenarioEvent each;
      each.name = event.name, each.wild = true, each.time = event.time, each.place = event.place;
      if (!add(entry, match, each)) break;
      wild.push_back(std::move(each));
    }
  }
}

}  // namespace momentree::io
