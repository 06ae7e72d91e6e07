#include <momentree/scenario/part_reader.hpp>

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include <momentree/scenario/events/argument_reader.hpp>
#include <momentree/simulate/events/topology_record.hpp>

namespace momentree::io {

namespace {

// A reader's state for a part: the scenario knows the names of a world, or nothing.
struct PartReading {
  explicit PartReading(const std::string& what) : out(what, {}), reading{scenario, out, "", Enclosure(), false} {}
  PartReading(const std::string& what, const Model& model) : PartReading(what) {
    scenario.model = model;
    for (int b = 0; b < model.size(); ++b) reading.bodies.emplace(model[BodyId{b}].name, Place{});
    for (const Spring& spring : model.springs()) reading.springs.emplace(spring.name, Place{});
  }
  PartReading(const std::string& what, const World& world) : PartReading(what, world.model()) {
    for (const JointId number : present_joints(world)) {
      const std::string joint(world.joint_name(number));
      kinds.emplace(joint, &info(world.joint(number).kind));
      reading.joints.emplace(joint, Place{});
    }
    for (const Mechanism& mechanism : world.mechanisms()) reading.mechanisms.emplace(mechanism.name, Place{});
  }

  // The value of an action's key in an event, with the match of a wildcard in its condition, or null.
  std::vector<Action> actions(const std::string& key, const Value& value, const TriggerMatch* match) {
    ScenarioEvent event;
    event.time = std::numeric_limits<double>::infinity();
    event.after = "a trigger";  // all matches of a wildcard in the action happen together
    std::vector<ScenarioEvent> wild;
    read_actions(value, key, event, match, wild, reading);
    for (const Reading::LateEntry& late : std::exchange(reading.late, {})) {
      ArgumentReader reader(*late.value, *late.action, {"", late.match, late.match}, late.time, reading);
      reader.kinds_of = [this](const std::string& joint) {
        const auto found = kinds.find(joint);
        return found == kinds.end() ? std::vector<const KindInfo*>() : std::vector<const KindInfo*>{found->second};
      };
      reader.read();
    }
    return std::move(event.actions);
  }

  void check() {
    if (out.errors() > 0) throw_all();
  }
  [[noreturn]] void throw_all() {
    std::vector<Diagnostic> found = out.take();
    std::erase_if(found, [](const Diagnostic& each) { return each.severity != Severity::error; });
#if defined(__cpp_exceptions)
    throw InputError(std::move(found));
#else
    throw_error(found.front().error());
#endif
  }

  Scenario scenario;
  Diagnostics out;
  Reading reading;
  std::unordered_map<std::string, const KindInfo*> kinds;
};

Value with_entry(const Value& table, const char* key, const std::string& text) {
  Value::Table entries = table.table() ? *table.table() : Value::Table{};
  entries.insert(entries.begin(), Value::Entry{key, table.place, Value(text, table.place)});
  return {std::move(entries), table.place};
}

}  // namespace

BodyPart PartReader::body(const std::string& name, const Value& table) const {
  PartReading part(what_);
  const std::size_t slash = name.find('/');
  const std::string mechanism = name.substr(0, slash == std::string::npos ? 0 : slash);
  const std::string bare = slash == std::string::npos ? name : name.substr(slash + 1);
  if (slash != std::string::npos) check_bare_name(mechanism, table.place, "a mechanism", part.out);
  const Value complete = with_entry(table, "name", bare);
  BodyEntry read = read_body(complete, mechanism, part.reading);
  part.check();
  read.spec.name = name;
  const bool named = read.bare_joint != read.bare_name;
  read.spec.joint_name = !named ? name : slash == std::string::npos ? read.bare_joint : mechanism + "/" + read.bare_joint;
  return {std::move(read.spec), std::move(read.shape), std::move(read.collision), std::move(read.collision_shapes)};
}

void PartReader::add_floor(const Value& value, Model& model) const {
  PartReading part(what_, model);
  const std::size_t before = model.colliders().size();
  read_floor(value, part.reading);
  part.check();
  const std::vector<Collider>& all = part.scenario.model.colliders();
  if (all.size() > before) model.add_collider(all.back());
  if (part.reading.floor_rule) model.add_contact_rule(*part.reading.floor_rule);
}

void PartReader::add_ground(const Value& value, Model& model, std::vector<Shape>& shapes) const {
  PartReading part(what_, model);
  read_ground(value, part.reading);
  part.check();
  const std::vector<Collider>& all = part.scenario.model.colliders();
  for (std::size_t i = model.colliders().size(); i < all.size(); ++i) {
    model.add_collider(all[i]);
    note_collision_shapes(model, {part.scenario.collision_shapes[i]}, shapes);
  }
}

void PartReader::add_contact(const Value& table, Model& model) const {
  PartReading part(what_, model);
  read_contact(table, part.reading);
  part.check();
  model.add_contact_rule(part.scenario.model.contact_rules().back());
}

std::vector<BodyForce> PartReader::forces(const Value& table, const Model& model) const {
  PartReading part(what_, model);
  const std::size_t before = model.forces().size();
  read_force(table, part.reading);
  part.check();
  const std::vector<BodyForce>& all = part.scenario.model.forces();
  return {all.begin() + static_cast<std::ptrdiff_t>(before), all.end()};
}

void PartReader::add_element(const std::string& kind, const std::string& name, const Value& table, Model& model) const {
  PartReading part(what_, model);
  for (int b = 0; b < model.size(); ++b) part.reading.joints.emplace(model[BodyId{b}].joint_name, Place{});
  for (const ElementTable& element : element_tables())
    if (element.keys->definition == kind) element.read(name.empty() ? table : with_entry(table, "name", name), part.reading);
  part.check();
  const Model& read = part.scenario.model;
  if (read.springs().size() > model.springs().size()) model.add_spring(read.springs().back());
  if (read.couplings().size() > model.couplings().size()) model.add_coupling(read.couplings().back());
  if (read.elements().size() > model.elements().size()) model.add_element(read.elements().back());
}

LoopSpec PartReader::loop(const std::string& name, const Value& table, const Model& model) const {
  PartReading part(what_, model);
  for (const BodySpec& body : model.bodies()) part.reading.joints.emplace(body.joint_name, Place{});
  for (const LoopSpec& loop : model.loops()) part.reading.joints.emplace(loop.name, Place{});
  read_loop(with_entry(table, "name", name), part.reading);
  part.check();
  return part.scenario.model.loops().back();
}

std::vector<TriggerPart> PartReader::triggers(const Value& event, const World& world) const {
  PartReading part(what_, world);
  std::optional<std::vector<TriggerMatch>> matches = matches_of_trigger(event, part.reading);
  part.check();
  std::vector<TriggerPart> all;
  const auto read = [&](std::shared_ptr<const TriggerMatch> match) {
    Fields fields(event, event_table, part.out);
    ScenarioEvent scheduled;
    read_trigger(fields, scheduled, match.get(), part.reading);
    fields.finish();
    check_solid_uses(world.model(), part.reading.solid_uses, part.out);
    part.check();
    all.push_back({std::move(scheduled.condition), std::move(match)});
  };
  if (!matches) read(nullptr);
  if (matches)
    for (TriggerMatch& match : *matches) read(std::make_shared<const TriggerMatch>(std::move(match)));
  return all;
}

std::vector<Action> PartReader::actions(const std::string& key, const Value& value, const TriggerPart& trigger,
                                        const World& world) const {
  const std::vector<std::string> known = action_keys();
  if (std::find(known.begin(), known.end(), key) == known.end())
    throw_error({"unknown action '" + key + "'", "", did_you_mean(key, known)});
  PartReading part(what_, world);
  std::vector<Action> all = part.actions(key, value, trigger.match.get());
  part.check();
  return all;
}

std::vector<Action> actions_now(const Value& table, const World& world, std::string& problem) {
  if (table.table() == nullptr || table.table()->empty())
    problem = "an action is a table with its key, for example {\"break\": \"chain/41\"}";
  PartReading part("", world);
  const std::vector<std::string>& known = scenario_actions();
  std::vector<Action> all;
  for (std::size_t i = 0; problem.empty() && i < table.table()->size(); ++i) {
    const auto& [key, place, value] = (*table.table())[i];
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      part.out.error(place, "unknown action '" + key + "'", did_you_mean(key, known));
      continue;
    }
    std::vector<Action> read = part.actions(key, value, nullptr);
    std::move(read.begin(), read.end(), std::back_inserter(all));
  }
  for (const Diagnostic& each : part.out.take())
    if (problem.empty() && each.severity == Severity::error) problem = each.what + (each.hint.empty() ? "" : "; " + each.hint);
  return all;
}

std::shared_ptr<momentree::Quantity> PartReader::quantity(const Value& table, const World& world,
                                                          const std::vector<std::string>& joints) const {
  PartReading part(what_, world);
  for (const std::string& joint : joints) part.reading.joints.emplace(joint, Place{});
  std::shared_ptr<momentree::Quantity> found = read_quantity(table, "a measure", part.reading);
  for (const Reading::JointUse& use : part.reading.joint_uses)
    if (part.reading.springs.contains(use.name)) {
      if (!use.springs_too) part.out.error(use.place, use.key + ": " + in_quotes(use.name) + " is a spring, not a joint", "");
    } else if (!part.reading.joints.contains(use.name))
      part.out.error(use.place, use.key + ": there is no joint " + in_quotes(use.name),
                     part.reading.suggest(use.name, part.reading.joints));
  check_solid_uses(world.model(), part.reading.solid_uses, part.out);
  part.check();
  return found;
}

Integration PartReader::integration(const Value& table) const {
  PartReading part(what_);
  read_integrate(table, part.reading);
  part.check();
  return part.scenario.integration;
}

}  // namespace momentree::io
