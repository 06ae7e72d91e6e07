// [measure] and [stop].
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>

#include <momentree/base/characters.hpp>
#include <momentree/base/error.hpp>
#include <momentree/scenario/keys/schema_parts.hpp>
#include <momentree/scenario/part_reader.hpp>
#include <momentree/sweep/plan/sweep_keys.hpp>
#include <momentree/sweep/plan/sweep_reading.hpp>

namespace momentree::sweep {

namespace {

using io::Fields;

// Of events at contacts and cables, which rules and cables name.
void add_contact_names(const Model& model, std::vector<std::string>& names) {
  if (!model.has_contact()) return;
  std::vector<std::string> ends{""};
  for (const ContactRule& rule : model.contact_rules())
    if (!rule.name.empty()) ends.push_back(" " + rule.name);
  for (const char* what : {"impact", "rest", "lift", "slip", "stick"})
    for (const std::string& end : ends) names.push_back(what + end);
  for (const Spring& spring : model.springs())
    if (spring.inextensible) names.push_back("taut " + spring.name), names.push_back("slack " + spring.name);
  names.insert(names.end(), {"stepping", "resume", "pass"});
}

// The names of events that can happen. Joints may get a strength from an event.
std::vector<std::string> event_names(const io::Scenario& scenario, const Simulation& simulation) {
  std::vector<std::string> names;
  for (const io::ScenarioEvent& event : scenario.events)
    if (names.empty() || names.back() != event.name) names.push_back(event.name);
  const World& world = simulation.world();
  const Model& model = world.model();
  for (int b = 0; b < model.size(); ++b) names.push_back("strength of " + model[BodyId{b}].joint_name);
  for (const LoopSpec& loop : model.loops()) names.push_back("strength of " + loop.name);
  for (const Spring& spring : model.springs()) names.push_back("strength of " + spring.name);
  names.emplace_back("stop");
  add_contact_names(model, names);
  return names;
}

class MeasureReader {
 public:
  MeasureReader(io::Session& session, SweepReading& reading)
      : session_(session),
        reading_(reading),
        out_(reading.out),
        names_(event_names(session.scenario(), session.simulation())),
        known_(names_.begin(), names_.end()) {
    for (const io::JointKinds& joint : reading.sweep.joints) joints_.push_back(joint.name);
  }

  void read(const Value::Entry& entry) {
    Fields fields(entry.value, measure_table, out_, entry.key);
    const std::size_t errors = out_.errors();
    Measure measure;
    measure.name = entry.key;
    bool chosen = false;
    const auto once = [&](const char* key) -> const Value* {
      const Value* value = fields.find(key);
      if (value != nullptr && chosen) out_.error(value->place, entry.key + ": two things to record", "write two measures");
      chosen = chosen || value != nullptr;
      return value;
    };
    using What = EventMeasure::What;
    const Value* value_word = nullptr;
    for (const auto& [key, what] :
         {std::pair{"happened", What::happened}, {"time_of", What::time}, {"count", What::count}, {"event", What::value}})
      if (const Value* value = once(key)) {
        EventMeasure event;
        event.what = what;
        event.event = event_name(*value, key);
        if (const Value* number = fields.find("number")) event.number = number_of(*number, what);
        if (what == What::value) {
          value_word = fields.require("value", "for example value = \"lost\"");
          if (value_word != nullptr) event.value = certificate_value(*value_word);
        }
        describe(event, measure);
        measure.what = std::move(event);
      }
    using Fold = FoldMeasure::What;
    for (const auto& [key, what] : {std::pair{"max", Fold::max}, {"min", Fold::min}, {"mean", Fold::mean}})
      if (const Value* value = once(key)) {
        std::string about;
        std::optional<Source> source = read_source(*value, measure.unit, about);
        bool time = false;
        if (what != Fold::mean && (value_word = fields.find("value")) != nullptr) {
          const auto word = io::read_string(*value_word, "value", out_);
          time = word == "time";
          if (word && !time)
            out_.error(value_word->place, "value: expected \"time\"", "the time of the extreme; without it, its value");
        }
        if (time) measure.unit = "s";
        measure.about = (time ? std::string("time of the ") : std::string()) +
                        (what == Fold::max   ? "largest "
                         : what == Fold::min ? "smallest "
                                             : "mean ") +
                        about;
        if (source) measure.what = FoldMeasure{what, std::move(*source), time};
      }
    if (const Value* value = once("final")) {
      std::string about;
      if (std::optional<Source> source = read_source(*value, measure.unit, about))
        measure.what = InstantMeasure{std::move(*source), {}};
      measure.about = "final " + about;
    }
    if (const Value* value = once("column")) {
      std::string about;
      std::optional<Source> source = read_source(*value, measure.unit, about);
      const Value* at = fields.require("at", "the instant, as in at = \"0.5 s\"; or write final for the end of the run");
      const std::optional<double> time = at != nullptr ? fields.number("at") : std::nullopt;
      if (time && *time > session_.scenario().until)
        out_.error(at->place, "at: this instant is after the end of the run", "the scenario's run ends at its until");
      if (source && time) measure.what = InstantMeasure{std::move(*source), time};
      measure.about = about + " at an instant";
    }
    fields.finish();
    if (!chosen && out_.errors() == errors)
      out_.error(entry.value.place, entry.key + ": does not say what to record",
                 "one of: happened time_of count event max min mean final column");
    if (out_.errors() == errors) reading_.sweep.measures.push_back(std::move(measure));
  }

  std::string event_name(const Value& value, const char* key) {
    const auto name = io::read_string(value, key, out_);
    if (!name) return {};
    if (!known_.contains(*name))
      out_.error(value.place, std::string(key) + ": there is no event " + io::in_quotes(*name), did_you_mean(*name, names_));
    return *name;
  }

 private:
  int number_of(const Value& value, EventMeasure::What what) {
    const std::int64_t* number = value.integer();
    if (number == nullptr || *number == 0 || std::abs(*number) > 1'000'000'000) {
      out_.error(value.place, "number: expected 1 for the first event, 2 for the second, -1 for the last");
      return 1;
    }
    if (what == EventMeasure::What::count) out_.error(value.place, "number: goes with event, time_of and happened");
    return static_cast<int>(*number);
  }

  std::string certificate_value(const Value& value) {
    const auto word = io::read_string(value, "value", out_);
    if (!word) return {};
    if (std::find(event_values().begin(), event_values().end(), *word) == event_values().end()) {
      std::string hint = did_you_mean(*word, event_values());
      if (hint.empty()) hint = "one of: time lost released work before.kinetic after.kinetic hardest.linear …";
      out_.error(value.place, "value: an event has no " + io::in_quotes(*word), hint);
    }
    return *word;
  }

  static void describe(const EventMeasure& event, Measure& measure) {
    using What = EventMeasure::What;
    const std::string which = event.number == 1    ? ""
                              : event.number == -1 ? "the last "
                                                   : "no. " + std::to_string(event.number) + " of ";
    switch (event.what) {
      case What::happened: measure.about = which + event.event + " happened"; break;
      case What::time: measure.about = "time of " + which + event.event, measure.unit = "s"; break;
      case What::count: measure.about = "number of " + event.event; break;
      case What::value:
        measure.about = event.value + " of " + which + event.event, measure.unit = unit_of_event_value(event.value);
    }
  }

  std::optional<Source> read_source(const Value& value, std::string& unit, std::string& about) {
    const World& world = session_.simulation().world();
    if (const std::string* name = value.string()) {
      io::Diagnostic problem;
      std::optional<io::ResultColumn> column = io::ResultColumn::find(*name, world, reading_.sweep.joints, problem);
      if (!column) {
        out_.error(value.place, problem.what, problem.hint);
        return std::nullopt;
      }
      unit = column->unit();
      about = *name;
      return Source(std::move(*column));
    }
    if (!value.table()) {
      out_.error(value.place, std::string("expected a column or a quantity, not ") + value.type_name(),
                 "a column: \"tug/gripper.x\"; a quantity: { reaction_torque = \"tug/wrist\" }");
      return std::nullopt;
    }
    try {
      std::shared_ptr<const Quantity> quantity = io::PartReader(reading_.sweep.path).quantity(value, world, joints_);
      unit = unit_of(quantity->dimension());
      about = std::string(quantity->key()) + " of";
      for (const auto& names : {quantity->joints(), quantity->bodies(), quantity->mechanisms(), quantity->solids()})
        for (const std::string& name : names) about += ' ' + name;
      return Source(std::move(quantity));
    } catch (const io::InputError& error) {
      for (const io::Diagnostic& each : error.diagnostics) out_.error({each.line, each.column, 0}, each.what, each.hint);
      return std::nullopt;
    }
  }

  io::Session& session_;
  SweepReading& reading_;
  io::Diagnostics& out_;
  std::vector<std::string> names_;
  std::unordered_set<std::string> known_;
  std::vector<std::string> joints_;
};

}  // namespace

void read_measures(const Value& table, io::Session& session, SweepReading& reading) {
  io::Diagnostics& out = reading.out;
  const Value::Table& entries = io::read_table(table, "[measure]", out);
  if (table.table() != nullptr && entries.empty())
    out.error(table.place, "[measure]: nothing is recorded", "for example x = { final = \"tug/gripper.x\" }");
  std::unordered_set<std::string> columns = {"world", "status"};
  for (const ParameterColumn& column : parameter_columns(reading.sweep)) columns.insert(column.name);
  MeasureReader reader(session, reading);
  for (const Value::Entry& entry : entries) {
    if (out.full()) break;
    if (entry.key.empty() || first_invisible(entry.key) != std::string::npos)
      out.error(entry.place, "[measure]: this name is empty or has an invisible character");
    else if (!columns.insert(entry.key).second)
      out.error(entry.place, "[measure]: " + io::in_quotes(entry.key) + " is the name of another column", "choose another name");
    else
      reader.read(entry);
  }
}

void read_stop(const Value& table, const Simulation& simulation, SweepReading& reading) {
  io::Diagnostics& out = reading.out;
  Fields fields(table, stop_table, out);
  const std::vector<std::string> names = event_names(*reading.sweep.scenario, simulation);
  const auto take = [&](const Value& value) {
    const auto name = io::read_string(value, "after", out);
    if (!name) return;
    if (std::find(names.begin(), names.end(), *name) == names.end())
      out.error(value.place, "after: there is no event " + io::in_quotes(*name), did_you_mean(*name, names));
    reading.sweep.stop.events.push_back(*name);
  };
  if (const Value* after = fields.find("after")) {
    if (after->array())
      for (const Value& each : *after->array()) take(each);
    else
      take(*after);
  }
  if (const Value* steps = fields.find("steps")) {
    if (const auto number = io::read_whole(*steps, "steps", 1, std::numeric_limits<std::int64_t>::max(), out))
      reading.sweep.stop.steps = static_cast<long>(*number);
  }
  fields.finish();
}

}  // namespace momentree::sweep
