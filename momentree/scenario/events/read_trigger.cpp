// When an event happens: at an instant, after another event, periodically, or when a quantity crosses a threshold.
#include <cmath>
#include <limits>

#include <momentree/scenario/events/argument_reader.hpp>
#include <momentree/simulate/events/single_dof.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr Key after_entries[] = {
    {"event", string, "Name of the event", nullptr, ""},
    {"delay", number(dimension::time, Range::not_negative), "Delay after that event", "0"},
};
constexpr KeyTable after_table{"after", "", "A delay after another event", after_entries};

constexpr Key condition_entries[] = {
    {"exceeds", number("the unit of the quantity"), "Threshold: the event happens when the quantity rises above it"},
    {"below", number("the unit of the quantity"), "Threshold: the event happens when the quantity falls below it"},
    {"undetermined", choice("least_norm"),
     "For a reaction that closed loops leave open: take the one for which the sum of squares over all joints is least"},
};

constexpr Key event_entries[] = {
    {"name", string, "Name; default: #1, #2 … by its position in the file"},
    {"at", number(dimension::time, Range::not_negative), "Instant"},
    {"when", table(condition_table), ""},
    {"after", other(R"({"anyOf": [{"type": "string"}, @]})", after_table),
     "Name of another event that it follows, or a delay after it"},
    {"every", number(dimension::time, Range::positive), "Period"},
    {"from", number(dimension::time, Range::not_negative), "With every: the first instant", "0"},
    {"repeat", boolean, "With when: fires again after the quantity has gone back past the threshold", "false"},
    {"for", number(dimension::time, Range::positive), "With when: fires only after the condition has held this long"},
    {"locate", choice("exact|per step"), "With when: how the instant is located", R"("exact")"},
    {"hysteresis", number("the unit of the quantity"),
     "With repeat: how far back past the threshold; default: 1 % of the threshold"},
};

constexpr Key point_entries[] = {
    {"body", string, "Full name of the body", nullptr, ""},
    {"point", vector(dimension::length), "Point in the body's frame", "[0, 0, 0]"},
};

constexpr double unknown_time = std::numeric_limits<double>::infinity();

using momentree::Quantity;  // not that of joint parameters

// Sets the unit of a coordinate from the joint's kind, if the model of the file has the joint.
void set_unit(momentree::Quantity& quantity, const Value& value, Reading& reading) {
  auto* of_joint = dynamic_cast<quantities::SingleDof*>(&quantity);
  const Model& model = reading.scenario.model;
  if (of_joint == nullptr || !model.has_joint(of_joint->joint)) return;
  const KindInfo& kind = info(model.joint_spec(model.joint(of_joint->joint)).kind);
  of_joint->turns = kind.v_units[0] != 'm';
  if (kind.nq != 1 || kind.nv != 1)
    reading.out.error(value.place,
                      std::string(quantity.key()) + ": joint " + in_quotes(of_joint->joint) + " is " + kind.name + " and has " +
                          std::to_string(kind.nv) + " degrees of freedom",
                      "for joints with one degree of freedom");
}

bool is_time(const Value& value) {
  QuantityProblem ignored;
  return value.integer() || value.real() || (value.string() && parse_quantity(*value.string(), dimension::time, ignored));
}

// The quantity that the fields name, called `what` in messages; null: none, or one that is wrong and was reported.
std::shared_ptr<momentree::Quantity> quantity_in(Fields& fields, const std::string& what, const std::vector<std::string>& keys,
                                                 const TriggerMatch* match, Reading& reading) {
  Diagnostics& out = reading.out;
  const std::size_t errors = out.errors();
  std::shared_ptr<momentree::Quantity> quantity;
  for (const std::string& key : keys) {
    const Value* value = fields.find(key);
    if (!value) continue;
    if (quantity) {
      out.error(value->place, what + ": two quantities, '" + std::string(quantity->key()) + "' and '" + key + "'",
                "write two of them");
      continue;
    }
    quantity = make_quantity(key);
    ArgumentReader(*value, *quantity, match != nullptr ? *match : TriggerMatch{}, unknown_time, reading).read();
    if (out.errors() == errors) set_unit(*quantity, *value, reading);
    if (out.errors() == errors && !quantity->solids().empty()) reading.solid_uses.push_back({quantity, value->place});
  }
  return quantity;
}

std::string one_of(const std::vector<std::string>& keys) {
  std::string all = "one of:";
  for (const std::string& key : keys) all += " " + key;
  return all;
}

std::optional<Condition> read_condition(const Value& when, const TriggerMatch* match, Reading& reading) {
  Diagnostics& out = reading.out;
  const std::size_t errors = out.errors();
  const std::vector<std::string> keys = quantity_keys();  // they outlive the fields, which store views of them
  Fields fields(when, condition_table, out);
  fields.not_mistakes(keys);
  const std::shared_ptr<momentree::Quantity> quantity = quantity_in(fields, "when", keys, match, reading);
  const bool above = fields.has("exceeds"), below = fields.has("below");
  const Value *over = fields.find("exceeds"), *under = fields.find("below");
  const Value* threshold = below ? under : over;
  const auto undetermined = fields.string("undetermined");
  if (undetermined && *undetermined != "least_norm")
    out.error(fields.place_of("undetermined"), "undetermined: there is no " + in_quotes(*undetermined), "\"least_norm\"");
  fields.finish();
  if (!quantity && out.errors() == errors) out.error(fields.place(), "when: names no quantity", one_of(keys));
  if (quantity && (!quantity->has_threshold() || (threshold == nullptr && quantity->drop_threshold()))) {
    if ((above || below) && out.errors() == errors)
      out.error(threshold->place, "when: " + std::string(quantity->key()) + " takes no threshold", "leave it out");
    if (out.errors() != errors) return std::nullopt;
    return Condition(quantity, 0.5, true);
  }
  if (above == below && out.errors() == errors)
    out.error(fields.place(), above ? "when: both 'exceeds' and 'below'" : "when: has no threshold", "exceeds = … or below = …");
  if (out.errors() != errors || !quantity) return std::nullopt;
  const auto number = read_number(*threshold, quantity->dimension(), above ? "exceeds" : "below", out);
  if (!number) return std::nullopt;
  if (quantity->never_negative() && !(*number > 0)) {
    out.error(threshold->place, "when: " + std::string(quantity->key()) + " is never negative: the threshold must be positive");
    return std::nullopt;
  }
  Condition condition(quantity, *number, above);
  condition.least_norm = undetermined.has_value();
  return condition;
}

// False if the unit of the threshold does not fit this quantity of a prismatic joint, or of a revolute one.
bool fits_unit(const Value& when, momentree::Quantity& quantity, bool along_axis) {
  if (auto* of_joint = dynamic_cast<quantities::SingleDof*>(&quantity)) of_joint->turns = !along_axis;
  for (const char* key : {"exceeds", "below"})
    if (const Value::Entry* threshold = when.find(key); threshold && threshold->value.string()) {
      QuantityProblem ignored;
      return parse_quantity(*threshold->value.string(), quantity.dimension(), ignored).has_value();
    }
  return true;
}

}  // namespace

constinit const KeyTable condition_table{
    "when", "condition", "A quantity and its threshold", condition_entries, {{KeyRule::How::not_two, "exceeds below"}}};
constinit const KeyTable event_table{"[[event]]",
                                     "event",
                                     "An event: its instant, and one or more actions",
                                     event_entries,
                                     {{KeyRule::How::one, "at when after every"}}};
constinit const KeyTable point_table{"point", "point", "A point of a body", point_entries};

std::shared_ptr<momentree::Quantity> read_quantity(const Value& table, const std::string& what, Reading& reading) {
  Diagnostics& out = reading.out;
  const std::size_t errors = out.errors();
  const std::vector<std::string> keys = quantity_keys();
  Fields fields(table, what, out);
  std::shared_ptr<momentree::Quantity> quantity = quantity_in(fields, what, keys, nullptr, reading);
  fields.finish();
  if (!quantity && out.errors() == errors) out.error(fields.place(), what + ": names no quantity", one_of(keys));
  return out.errors() == errors ? quantity : nullptr;
}

std::optional<std::vector<TriggerMatch>> matches_of_trigger(const Value& event, Reading& reading) {
  const Value::Entry* when = event.find("when");
  const Value *pattern = nullptr, *another = nullptr;
  std::shared_ptr<momentree::Quantity> what;
  bool joints = false, bodies = false;
  if (!when || !when->value.table()) return std::nullopt;
  const auto visit = [&](const Value& name) {
    if (!name.string() || name.string()->find('*') == std::string::npos) return;
    if (pattern && *pattern->string() != *name.string()) another = &name;
    if (!pattern) pattern = &name;
  };
  for (const std::string& key : quantity_keys()) {
    const Value::Entry* quantity = when->value.find(key);
    if (!quantity) continue;
    what = make_quantity(key);
    joints = !what->joints().empty(), bodies = !what->bodies().empty() || !what->solids().empty();
    if (!joints && !bodies) continue;  // names a mechanism
    const auto visit_entries = [&visit](const Value& entry) {
      visit(entry);
      for (const char* field : {"joint", "body"})
        if (const Value::Entry* name = entry.find(field)) visit(name->value);
    };
    visit_entries(quantity->value);
    if (quantity->value.array())
      for (const Value& entry : *quantity->value.array()) visit_entries(entry);
    if (pattern) break;
  }
  if (!pattern) return std::nullopt;
  std::vector<TriggerMatch> matches;
  Diagnostics& out = reading.out;
  if (another) {
    out.error(another->place, "when: two wildcards, " + in_quotes(*pattern->string()) + " and " + in_quotes(*another->string()),
              "one of them should be a name");
    return matches;
  }
  const std::string& name = *pattern->string();
  int others = 0;
  std::vector<TriggerMatch> of_other_unit;
  const Model& model = reading.scenario.model;
  const bool of_one = what->of_single_dof();
  for (const std::string& found :
       bodies ? matching_bodies(name, reading) : matching_joints(name, what->takes_springs(), reading)) {
    TriggerMatch match{name, found, found};
    if (bodies && model.has_body(found)) match.joint = model[model.body(found)].joint_name;
    if (!bodies && model.has_joint(found)) {
      const KindInfo& kind = info(model.joint_spec(model.joint(found)).kind);
      if (of_one && (kind.nv != 1 || kind.nq != 1) && ++others) continue;
      match.body = model[model.body_of(model.joint(found))].name;
      if (of_one && !fits_unit(when->value, *what, kind.v_units[0] == 'm')) {
        of_other_unit.push_back(std::move(match));
        continue;
      }
    }
    matches.push_back(std::move(match));
  }
  if (matches.empty()) matches = std::move(of_other_unit);  // an error in the unit is reported for one of them
  if (matches.empty() && others > 0) {
    out.error(pattern->place, "when: no joint that matches " + in_quotes(name) + " has one degree of freedom",
              "position and speed need a joint with one degree of freedom");
    return matches;
  }
  if (matches.empty() && !reading.opaque.contains(name.substr(0, name.find('/'))))
    out.error(pattern->place, std::string("when: no ") + (bodies ? "body" : "joint") + " matches " + in_quotes(name),
              "* matches within a name: \"chain/*\"");
  return matches;
}

void read_trigger(Fields& fields, ScenarioEvent& event, const TriggerMatch* match, Reading& reading) {
  Diagnostics& out = reading.out;
  int triggers = 0;
  for (const char* key : {"at", "when", "after", "every"}) triggers += fields.has(key);
  if (triggers == 0 && !fields.mistaken("when"))
    out.error(fields.place(), "event " + in_quotes(event.name) + " has no instant",
              "for example at = \"1.8 s\", or when = { reaction_force = \"crane/hook\", exceeds = \"4 kN\" }");
  if (triggers > 1)
    out.error(fields.place(), "event " + in_quotes(event.name) + " has more than one of at, when, after and every",
              "write two events");

  if (const auto at = fields.number("at")) event.time = *at;
  if (const Value* when = fields.find("when")) {
    event.time = unknown_time;
    event.condition = read_condition(*when, match, reading);
  }
  if (const Value* after = fields.find("after")) {
    event.time = unknown_time;
    if (after->table()) {
      Fields inner(*after, after_table, out);
      if (const Value* name = inner.require("event")) event.after = read_string(*name, "event", out).value_or("");
      event.delay = inner.number("delay").value_or(0);
      inner.finish();
    } else if (is_time(*after)) {
      out.error(after->place, "after: names no event",
                "write after = { event = \"grasp\", delay = \"0.5 s\" }, or an instant: at = \"0.5 s\"");
    } else {
      event.after = read_string(*after, "after", out).value_or("");
    }
    event.after_place = after->place;
  }
  if (const auto every = fields.number("every")) event.period = *every;
  if (const auto from = fields.number("from")) {
    event.time = *from;
    if (!fields.has("every")) out.error(fields.place_of("from"), "'from' goes with 'every'");
  }

  const auto repeat = fields.boolean("repeat");
  const auto lasting = fields.number("for");
  const auto locate = fields.string("locate");
  const Value* hysteresis = fields.find("hysteresis");
  if (!fields.has("when")) {
    for (const char* key : {"repeat", "for", "locate", "hysteresis"})
      if (fields.has(key)) out.error(fields.place_of(key), "'" + std::string(key) + "' goes with 'when'");
    return;
  }
  if (locate && *locate != "exact" && *locate != "per step")
    out.error(fields.place_of("locate"), "locate: there is no " + in_quotes(*locate), "\"exact\" or \"per step\"");
  if (!event.condition) return;
  Condition& condition = *event.condition;
  condition.exact = !locate || *locate != "per step";
  condition.duration = lasting.value_or(0);
  condition.repeats = repeat.value_or(false);
  if (!hysteresis) return;
  if (!condition.repeats) out.error(hysteresis->place, "'hysteresis' goes with repeat = true");
  if (const auto width = read_number(*hysteresis, condition.what->dimension(), "hysteresis", out)) {
    if (*width < 0) out.error(hysteresis->place, "hysteresis: must not be negative");
    condition.hysteresis = *width;
  }
}

}  // namespace momentree::io
