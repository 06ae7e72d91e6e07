// [[event]]: an instant or condition, and the actions, in the order of its keys.
#include <algorithm>

#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

namespace {

// One event: that of `match`, if its condition has a wildcard. False if it has no effect.
bool read_one(const Value& table, const std::string& name, bool named, const TriggerMatch* match, Reading& reading) {
  Fields fields(table, event_table, reading.out);
  const std::vector<std::string>& keys = scenario_actions();
  fields.not_mistakes(keys);
  fields.find("name");
  ScenarioEvent event;
  event.place = fields.place();
  event.name = name;
  event.named = named;
  event.wild = match != nullptr;
  read_trigger(fields, event, match, reading);

  bool acts = false;
  std::vector<ScenarioEvent> wild;
  for (const std::string& key : keys) fields.find(key);
  if (const Value::Table* entries = table.table())
    for (const Value::Entry& entry : *entries) {
      const std::string key(fields.meant(entry));
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) continue;
      acts = true;
      read_actions(entry.value, key, event, match, wild, reading);
    }
  fields.finish();
  if (!event.actions.empty()) reading.scenario.events.push_back(std::move(event));
  for (ScenarioEvent& each : wild) reading.scenario.events.push_back(std::move(each));
  return acts;
}

}  // namespace

void read_event(const Value& table, int number, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, event_table, out);
  std::string event = "#" + std::to_string(number);
  bool named = false;
  if (const auto name = fields.string("name"); name && check_bare_name(*name, fields.place_of("name"), "an event", out)) {
    event = *name;
    named = true;
    reading.note(reading.events, *name, fields.place_of("name"), "event");
  }
  if (!table.table()) return;
  bool acts = true;
  if (const auto matches = matches_of_trigger(table, reading)) {
    const std::size_t errors = out.errors();
    for (const TriggerMatch& match : *matches) {
      acts = read_one(table, event, named, &match, reading);
      if (!acts || errors != out.errors()) break;  // the other matches would have the same problem
    }
  } else {
    acts = read_one(table, event, named, nullptr, reading);
  }
  if (!acts) out.error(fields.place(), "event " + in_quotes(event) + " does nothing", "for example break = \"chain/41\"");
}

}  // namespace momentree::io
