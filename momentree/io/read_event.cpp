// [[event]]: an instant and what happens at it, in the order of its keys.
#include <algorithm>

#include <momentree/io/scenario_parts.hpp>

namespace momentree::io {

void read_event(const Value& table, int number, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, "[[event]]", out);
  ScenarioEvent event;
  event.place = fields.place();
  event.name = "#" + std::to_string(number);
  if (const auto name = fields.string("name"); name && check_bare_name(*name, fields.place_of("name"), "an event", out)) {
    event.name = *name;
    event.named = true;
    reading.note(reading.events, *name, fields.place_of("name"), "event");
  }
  read_trigger(fields, event, reading);

  bool acts = false;
  std::vector<ScenarioEvent> wild;
  std::vector<std::string> keys = action_keys();
  keys.erase(std::find(keys.begin(), keys.end(), "reroot"));  // files re-root where they join; by itself it is for C++
  for (const std::string& key : keys) fields.find(key);
  if (const Value::Table* entries = table.table())
    for (const Value::Entry& entry : *entries) {
      if (std::find(keys.begin(), keys.end(), entry.key) == keys.end()) continue;
      acts = true;
      read_actions(entry.value, entry.key, event, wild, reading);
    }
  fields.finish();
  if (!acts) out.error(fields.place(), "event " + in_quotes(event.name) + " does nothing", "for example break = \"chain/41\"");
  if (!event.actions.empty()) reading.scenario.events.push_back(std::move(event));
  for (ScenarioEvent& each : wild) reading.scenario.events.push_back(std::move(each));
}

}  // namespace momentree::io
