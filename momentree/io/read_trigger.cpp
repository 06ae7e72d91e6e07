// When an event happens: at an instant, after another event, every so often, or when a quantity passes a threshold.
#include <cmath>
#include <limits>

#include <momentree/io/scenario_parts.hpp>
#include <momentree/simulate/one_freedom.hpp>

namespace momentree::io {

namespace {

constexpr double unknown_time = std::numeric_limits<double>::infinity();

class QuantityReader final : public QuantityFields {
 public:
  QuantityReader(const Value& value, std::string key, Reading& reading)
      : value_(value), key_(std::move(key)), reading_(reading), out_(reading.out) {}

  void joint(std::string& name) override {
    const Value* value = field("joint");
    const auto text = value ? read_string(*value, key_, out_) : std::nullopt;
    if (!text) return;
    if (text->find('*') != std::string::npos)
      return not_supported_yet(value->place, "a wildcard in a condition", out_, "write one event for each joint");
    name = *text;
    reading_.joint_uses.push_back({name, key_, value->place, unknown_time});
  }

  void mechanism(std::string& name) override {
    const auto text = read_string(value_, key_, out_);
    if (!text) return;
    name = *text;
    // A part that comes off is a mechanism named after its root body.
    if (!reading_.mechanisms.contains(name) && !reading_.bodies.contains(name))
      out_.error(value_.place, key_ + ": there is no mechanism " + in_quotes(name), reading_.suggest(name, reading_.mechanisms));
  }

  void point(int number, int count, std::string& body, Vec3& point) override {
    const Value* entry = &value_;
    if (count > 1) {
      if (!value_.array() || static_cast<int>(value_.array()->size()) != count) {
        if (number == 0)
          out_.error(value_.place, key_ + ": expected a list of two bodies", "for example [\"tug/gripper\", \"satellite/hull\"]");
        return;
      }
      entry = &(*value_.array())[static_cast<std::size_t>(number)];
    }
    Place place = entry->place;
    std::optional<std::string> name;
    if (entry->table()) {
      Fields fields(*entry, key_, out_);
      if (const Value* given = fields.require("body")) name = read_string(*given, "body", out_), place = given->place;
      point = fields.vec3("point", dimension::length).value_or(Vec3{});
      fields.finish();
    } else {
      name = read_string(*entry, key_, out_);
    }
    if (!name) return;
    body = *name;
    if (body == "ground" && count > 1) return;
    if (!reading_.bodies.contains(body))
      out_.error(place, key_ + ": there is no body " + in_quotes(body), reading_.suggest(body, reading_.bodies));
  }

  void component(std::string& name) override {
    const Value* value = field("component");
    const auto text = value ? read_string(*value, "component", out_) : std::nullopt;
    if (!text) return;
    if (text->size() != 2 || std::string("fm").find((*text)[0]) == std::string::npos ||
        std::string("xyz").find((*text)[1]) == std::string::npos)
      return out_.error(value->place, "component: there is no " + in_quotes(*text), "one of: fx fy fz mx my mz");
    name = *text;
  }

  void finish() {
    if (fields_) fields_->finish();
  }

 private:
  // A table's field, or the value itself where it is a plain name.
  const Value* field(const char* key) {
    if (!value_.table()) return key == std::string_view("joint") ? &value_ : nullptr;
    if (!fields_) fields_.emplace(value_, key_, out_);
    return fields_->require(key);
  }

  const Value& value_;
  std::string key_;
  Reading& reading_;
  Diagnostics& out_;
  std::optional<Fields> fields_;
};

// Units of a coordinate are those of the joint's kind, where the file's model has it.
void know_unit(Quantity& quantity, const Value& value, Reading& reading) {
  auto* of_joint = dynamic_cast<quantities::OneFreedom*>(&quantity);
  const Model& model = reading.scenario.model;
  if (of_joint == nullptr || !model.has_joint(of_joint->joint)) return;
  const KindInfo& kind = info(model[model.joint(of_joint->joint)].joint.kind);
  of_joint->turns = kind.v_units[0] != 'm';
  if (kind.nq != 1 || kind.nv != 1)
    reading.out.error(value.place,
                      std::string(quantity.key()) + ": joint " + in_quotes(of_joint->joint) + " is " + kind.name + " and has " +
                          std::to_string(kind.nv) + " freedoms",
                      "for joints with one freedom");
}

std::optional<Condition> read_condition(const Value& when, Reading& reading) {
  Diagnostics& out = reading.out;
  const std::size_t errors = out.errors();
  Fields fields(when, "when", out);
  std::shared_ptr<Quantity> quantity;
  std::string all = "one of:";
  for (const std::string& key : quantity_keys()) {
    all += " " + key;
    const Value* value = fields.find(key);
    if (!value) continue;
    if (quantity) {
      out.error(value->place, "when: two quantities, '" + std::string(quantity->key()) + "' and '" + key + "'",
                "write two events");
      continue;
    }
    quantity = make_quantity(key);
    QuantityReader reader(*value, key, reading);
    quantity->fields(reader);
    reader.finish();
    if (out.errors() == errors) know_unit(*quantity, *value, reading);
  }
  const bool above = fields.has("exceeds"), below = fields.has("below");
  const Value* threshold = fields.find(below ? "below" : "exceeds");
  if (above && below) fields.find("exceeds");
  fields.finish();
  if (!quantity && out.errors() == errors) out.error(fields.place(), "when: names no quantity", all);
  if (above == below && out.errors() == errors)
    out.error(fields.place(), above ? "when: both 'exceeds' and 'below'" : "when: has no threshold", "exceeds = … or below = …");
  if (out.errors() != errors || !quantity) return std::nullopt;
  const auto number = read_number(*threshold, quantity->dimension(), above ? "exceeds" : "below", out);
  if (!number) return std::nullopt;
  const bool never_negative = (quantity->is_load() && quantity->key() != "reaction") || quantity->key() == "distance" ||
                              quantity->key() == "kinetic_energy";
  if (never_negative && !(*number > 0)) {
    out.error(threshold->place, "when: " + std::string(quantity->key()) + " is never negative: the threshold must be positive");
    return std::nullopt;
  }
  return Condition(std::move(quantity), *number, above);
}

}  // namespace

void read_trigger(Fields& fields, ScenarioEvent& event, Reading& reading) {
  Diagnostics& out = reading.out;
  int triggers = 0;
  for (const char* key : {"at", "when", "after", "every"}) triggers += fields.has(key);
  if (triggers == 0)
    out.error(fields.place(), "event " + in_quotes(event.name) + " has no instant",
              "for example at = \"1.8 s\", or when = { reaction_force = \"crane/hook\", exceeds = \"4 kN\" }");
  if (triggers > 1)
    out.error(fields.place(), "event " + in_quotes(event.name) + " has more than one of at, when, after and every",
              "write two events");

  if (const auto at = fields.not_negative("at", dimension::time)) event.time = *at;
  if (const Value* when = fields.find("when")) {
    event.time = unknown_time;
    event.condition = read_condition(*when, reading);
  }
  if (const Value* after = fields.find("after")) {
    event.time = unknown_time;
    if (after->table()) {
      Fields inner(*after, "after", out);
      if (const Value* name = inner.require("event")) event.after = read_string(*name, "event", out).value_or("");
      event.delay = inner.not_negative("delay", dimension::time).value_or(0);
      inner.finish();
    } else {
      event.after = read_string(*after, "after", out).value_or("");
    }
    event.after_place = after->place;
  }
  if (const auto every = fields.positive("every", dimension::time)) event.period = *every;
  if (const auto from = fields.not_negative("from", dimension::time)) {
    event.time = *from;
    if (!fields.has("every")) out.error(fields.place_of("from"), "'from' goes with 'every'");
  }

  const auto repeat = fields.boolean("repeat");
  const auto lasting = fields.positive("for", dimension::time);
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
