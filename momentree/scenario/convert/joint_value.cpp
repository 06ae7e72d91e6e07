// Converts a joint into the values of a scenario.
#include <algorithm>
#include <cmath>

#include <momentree/scenario/convert/describe.hpp>
#include <momentree/scenario/keys/joint_keys.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

using namespace document_values;

// Angles of more than one turn get a unit: without one they would give a warning that they may be meant in degrees.
Value coordinate(double x, char letter) {
  return letter == 'r' && std::isfinite(x) && std::fabs(x) > 6.2832 ? text(number_text(x) + " rad") : number(x);
}

Value coordinates(const Values& values, const char* letters) {
  if (values.size() == 1) return coordinate(values[0], letters[0]);
  Value::Array all;
  for (int i = 0; i < values.size(); ++i) all.push_back(coordinate(values[i], letters[i]));
  return value(std::move(all));
}

Value list_of(const Values& values) {
  Value::Array all;
  for (const double x : values) all.push_back(number(x));
  return value(std::move(all));
}

Value signal_value(const Signal& signal) {
  SignalParts parts(signal);
  const bool flat = parts.form == SignalParts::Form::sine && parts.amplitude == 0;
  if (parts.form == SignalParts::Form::number || flat) return number(parts.offset);
  Value::Table table;
  if (parts.form == SignalParts::Form::table) {
    Value::Array entries;
    for (const Signal::Knot& knot : parts.table) entries.push_back(value(Value::Array{number(knot.time), number(knot.value)}));
    add(table, "table", value(std::move(entries)));
    if (parts.ends == Signal::Ends::free) add(table, "ends", text("free"));
  } else if (parts.form == SignalParts::Form::ramp) {
    for (const SignalKey& key : ramp_keys())
      if (key.required || !parts.from_here) add(table, key.key, number(parts.*key.number));
  } else {
    // a sine with negative frequency equals one with positive frequency and another phase
    if (parts.frequency < 0) parts.amplitude *= -1, parts.frequency *= -1, parts.phase *= -1;
    Value::Table sine;
    for (const SignalKey& key : sine_keys())
      if (const double x = parts.*key.number; key.required || x != 0) add(sine, key.key, number(x));
    add(table, "sine", value(std::move(sine)));
  }
  return value(std::move(table));
}

Signal raised(const Signal& signal, double by) {
  SignalParts parts(signal);
  parts.offset += by;
  for (Signal::Knot& knot : parts.table) knot.value += by;
  return parts.signal();
}

// Parameters by their keys; those that have no effect are left out.
class JointValueWriter {
 public:
  JointValueWriter(const JointParameters& parameters, const KindInfo& kind) : settings_(parameters), kind_(kind) {
    JointParameters& p = settings_.parameters;
    if (p.rest == joint_zero(kind.kind)) p.rest = {};
    if (!p.rest.empty() && p.stiffness.empty()) p.stiffness = 0;
    if (p.limits.soft()) p.limits.restitution = {}, p.limits.rest_speed = none_.parameters.limits.rest_speed;
    // A scenario has one effort for each DoF, and the constant effort is part of it.
    std::vector<Signal>& effort = settings_.drive.effort;
    if (!p.effort.any() && effort.empty()) return;
    std::vector<Signal> all;
    for (int i = 0; i < kind.nv; ++i) {
      const auto k = static_cast<std::size_t>(effort.size() == 1 ? 0 : i);
      all.push_back(raised(k < effort.size() ? effort[k] : Signal(), p.effort.of(i)));
    }
    effort = std::move(all);
  }

  void write(Value::Table& table, std::span<const JointKey> keys, const JointGroup* in = nullptr) {
    for (const JointKey& key : keys) {
      const bool needed = key.required || (in && in->needs(key.key));
      if (!key.documents) std::visit([&](const auto& value) { write(table, key, value, needed); }, key.value);
    }
  }

 private:
  // `always`: also a value without effect
  void write(Value::Table& table, const JointKey& key, JointKey::PerDof at, bool always) {
    Values values = at(settings_);
    if (values.empty() && !key.required) return;
    if (values.empty()) values = key.range == Range::positive ? 1 : 0;
    always = always || (&at(settings_) == &settings_.parameters.stiffness && !settings_.parameters.rest.empty());
    if (!always && std::all_of(values.begin(), values.end(), [&](double x) { return x == key.infinite; })) return;
    if (key.quantity == Quantity::q) return add(table, key.key, coordinates(values, kind_.q_units));
    const bool alike = std::all_of(values.begin(), values.end(), [&](double x) { return x == values[0]; });
    add(table, key.key, alike ? number(values[0]) : list_of(values));
  }
  void write(Value::Table& table, const JointKey& key, JointKey::Number at, bool) {
    if (at(settings_) != at(none_)) add(table, key.key, number(at(settings_)));
  }
  void write(Value::Table& table, const JointKey& key, JointKey::Signals at, bool) {
    const std::vector<Signal>& signals = at(settings_);
    if (signals.empty()) return;
    const int count = key.quantity == Quantity::q ? kind_.nq : kind_.nv;
    Value::Array all;  // one signal applies to every DoF; a file has one for each
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(signals.size() == 1 ? 0 : i);
      all.push_back(signal_value(k < signals.size() ? signals[k] : Signal()));
    }
    add(table, key.key, count == 1 ? std::move(all.front()) : value(std::move(all)));
  }
  void write(Value::Table& table, const JointKey& key, const JointGroup& group, bool) {
    Value whole(Value::Table{}, Place{});
    write(*whole.table(), group.keys, &group);
    const bool lacks = group.either[0] && !whole.find(group.either[0]) && !whole.find(group.either[1]);
    const bool same = alike(group.keys, settings_, none_, [](const auto& a, const auto& b) { return a == b; });
    if (!whole.table()->empty() && !lacks && !same) add(table, key.key, std::move(whole));
  }

  JointSettings settings_, none_;
  const KindInfo& kind_;
};

void add_geometry(Value::Table& table, const JointSpec& joint, const Pose& at, const Pose& child_at) {
  const KindInfo& kind = info(joint.kind);
  if (kind.axis && !(joint.axis.x == 0 && joint.axis.y == 0 && joint.axis.z > 0)) add(table, "axis", list(joint.axis));
  if (kind.axis2) add(table, "axis2", list(joint.axis2));
  if (kind.pitch) add(table, "pitch", number(joint.pitch));
  if (Value::Table place = placement(at); !place.empty()) add(table, "at", value(std::move(place)));
  if (Value::Table place = placement(child_at); !place.empty()) add(table, "child_at", value(std::move(place)));
}

void add_start(Value::Table& table, const BodySpec& spec, const KindInfo& kind) {
  const auto& drive = spec.joint.parameters.drive;
  if (drive && drive->moves() && !drive->motion[0].signal().from_here()) return;  // the motion gives the initial values
  const bool one = kind.nq == 1 && kind.nv == 1;
  if (!spec.q.empty()) {
    const char* const key = !one ? "q" : kind.q_units[0] == 'r' ? "angle" : "position";
    add(table, key, coordinates(spec.q, kind.q_units));
  }
  if (drive && drive->moves()) return;
  if (!spec.v.empty()) add(table, one ? "speed" : "v", one ? number(spec.v[0]) : list_of(spec.v));
}

}  // namespace

Value::Table describe_joint(const BodySpec& spec, const std::string& name, const std::string& parent) {
  const KindInfo& kind = info(spec.joint.kind);
  Value::Table table;
  if (!name.empty()) add(table, "name", text(name));
  add(table, "kind", text(kind.name));
  if (!parent.empty()) add(table, "parent", text(parent));
  add_geometry(table, spec.joint, spec.at, spec.child_at);
  add_start(table, spec, kind);
  JointValueWriter(spec.joint.parameters, kind).write(table, joint_keys());
  return table;
}

Value::Table describe_loop(const LoopSpec& loop, const Model& model) {
  const KindInfo& kind = info(loop.joint.kind);
  Value::Table table;
  add(table, "name", text(loop.name));
  add(table, "kind", text(kind.name));
  add(table, "body", text(model[loop.body].name));
  if (!(loop.to == ground)) add(table, "to", text(model[loop.to].name));
  add_geometry(table, loop.joint, loop.at, loop.child_at);
  JointValueWriter(loop.joint.parameters, kind).write(table, joint_keys());
  if (!loop.assemble) add(table, "assemble", Value(false, Place{}));
  return table;
}

Value describe_signal(const Signal& signal) { return signal_value(signal); }

}  // namespace momentree::io
