// Converts a joint into the values of a scenario.
#include <algorithm>
#include <cmath>
#include <limits>

#include <momentree/io/convert/describe.hpp>
#include <momentree/io/number_text.hpp>

namespace momentree::io {

namespace {

using namespace document_values;

constexpr double infinity = std::numeric_limits<double>::infinity();

// Angles of more than one turn get a unit: without one they would give a warning that they may be meant in degrees.
Value coordinate(double x, char letter) {
  return letter == 'r' && std::fabs(x) > 6.2832 ? text(number_text(x) + " rad") : number(x);
}

Value coordinates(const Values& values, const char* letters) {
  Value::Array all;
  for (int i = 0; i < values.size(); ++i) all.push_back(coordinate(values[i], letters[i]));
  return value(std::move(all));
}

// Stops, which may be one number for all DoFs.
void add_stops(Value::Table& table, const char* key, const Values& values, const char* letters) {
  if (values.size() == 1)
    add(table, key, coordinate(values[0], letters[0]));
  else if (!values.empty())
    add(table, key, coordinates(values, letters));
}

Value list_of(const Values& values) {
  Value::Array all;
  for (const double x : values) all.push_back(number(x));
  return value(std::move(all));
}

// A single number if it applies to every DoF.
void add_values(Value::Table& table, const char* key, const Values& values) {
  if (values.empty()) return;
  const bool alike = std::all_of(values.begin(), values.end(), [&](double x) { return x == values[0]; });
  add(table, key, alike ? number(values[0]) : list_of(values));
}
void add_any(Value::Table& table, const char* key, const Values& values) {
  if (values.any()) add_values(table, key, values);
}

Value signal_value(const Signal& signal, double more = 0) {
  Value::Table table;
  if (!signal.knots().empty()) {
    Value::Array entries;
    for (const Signal::Knot& knot : signal.knots())
      entries.push_back(value(Value::Array{number(knot.time), number(knot.value + more)}));
    add(table, "table", value(std::move(entries)));
    if (signal.ends() == Signal::Ends::free) add(table, "ends", text("free"));
  } else if (signal.ramp_rate() != 0 || signal.from_here()) {
    add(table, "rate", number(signal.ramp_rate()));
    if (!signal.from_here()) add(table, "offset", number(signal.offset() + more));
  } else if (signal.amplitude() != 0) {
    // a sine with negative frequency equals one with positive frequency and another phase
    const double sign = signal.frequency() < 0 ? -1 : 1;
    Value::Table sine;
    add(sine, "amplitude", number(sign * signal.amplitude()));
    add(sine, "frequency", number(sign * signal.frequency()));
    if (signal.phase() != 0) add(sine, "phase", number(sign * signal.phase()));
    if (signal.offset() + more != 0) add(sine, "offset", number(signal.offset() + more));
    add(table, "sine", value(std::move(sine)));
  } else {
    return number(signal.offset() + more);
  }
  return value(std::move(table));
}

// One signal applies to every DoF; a file has one for each.
Value signals_value(const std::vector<Signal>& signals, const Values& more, int count) {
  Value::Array all;
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(signals.size() == 1 ? 0 : i);
    all.push_back(signal_value(k < signals.size() ? signals[k] : Signal(), more.of(i)));
  }
  return count == 1 ? std::move(all.front()) : value(std::move(all));
}

Value::Table drive_table(const JointParameters& p, const KindInfo& kind) {
  static const JointDrive none{};
  const JointDrive& drive = p.drive ? *p.drive : none;
  Value::Table table;
  if (p.effort.any() || !drive.effort.empty()) add(table, "effort", signals_value(drive.effort, p.effort, kind.nv));
  if (drive.pd.any()) {
    Value::Table pd;
    add_values(pd, "kp", drive.pd.kp);
    add_values(pd, "kd", drive.pd.kd);
    if (!drive.pd.target.empty()) add(pd, "target", signals_value(drive.pd.target, {}, kind.nq));
    if (!drive.pd.target_speed.empty()) add(pd, "target_speed", signals_value(drive.pd.target_speed, {}, kind.nv));
    Values most;
    bool bounded = false;
    for (const double x : drive.pd.max_effort) {
      bounded = bounded || std::isfinite(x);
      most.push_back(std::min(x, std::numeric_limits<double>::max()));
    }
    if (bounded) add_values(pd, "max_effort", most);
    add(table, "pd", value(std::move(pd)));
  }
  if (drive.moves()) add(table, "motion", signal_value(drive.motion.front().signal()));
  return table;
}

Value::Table limits_table(const JointLimits& limits, const KindInfo& kind) {
  Value::Table table;
  add_stops(table, "lower", limits.lower, kind.q_units);
  add_stops(table, "upper", limits.upper, kind.q_units);
  if (limits.soft()) {
    add_values(table, "stiffness", limits.stiffness);
    add_any(table, "damping", limits.damping);
    return table;
  }
  add_any(table, "restitution", limits.restitution);
  if (limits.rest_speed != JointLimits{}.rest_speed) add(table, "rest_speed", number(limits.rest_speed));
  return table;
}

void add_parameters(Value::Table& table, const JointParameters& p, const KindInfo& kind) {
  const Values zero = joint_zero(kind.kind);
  const bool rests_apart = !p.rest.empty() && !(p.rest == zero);
  add_any(table, "damping", p.damping);
  if (p.stiffness.any() || rests_apart) add_values(table, "stiffness", p.stiffness.empty() ? Values(0) : p.stiffness);
  if (rests_apart) add(table, "rest", kind.nq == 1 ? coordinate(p.rest[0], kind.q_units[0]) : coordinates(p.rest, kind.q_units));
  add_any(table, "armature", p.armature);
  if (p.friction.given()) {
    Value::Table friction;
    add_values(friction, "coulomb", p.friction.coulomb.empty() ? Values(0) : p.friction.coulomb);
    add_values(friction, "speed", p.friction.speed.empty() ? Values(1) : p.friction.speed);
    add(table, "friction", value(std::move(friction)));
  }
  if (Value::Table drive = drive_table(p, kind); !drive.empty()) add(table, "drive", value(std::move(drive)));
  if (p.limits.any()) add(table, "limits", value(limits_table(p.limits, kind)));
  if (!p.strength.any()) return;
  Value::Table strength;
  if (p.strength.force < infinity) add(strength, "force", number(p.strength.force));
  if (p.strength.torque < infinity) add(strength, "torque", number(p.strength.torque));
  add(table, "strength", value(std::move(strength)));
}

void add_start(Value::Table& table, const BodySpec& spec, const KindInfo& kind) {
  const auto& drive = spec.joint.parameters.drive;
  if (drive && drive->moves() && !drive->motion[0].signal().from_here()) return;  // the motion gives the initial values
  const bool one = kind.nq == 1 && kind.nv == 1;
  if (!(spec.q == joint_zero(kind.kind))) {
    const char* const key = !one ? "q" : kind.q_units[0] == 'r' ? "angle" : "position";
    add(table, key, one ? coordinate(spec.q[0], kind.q_units[0]) : coordinates(spec.q, kind.q_units));
  }
  if (drive && drive->moves()) return;
  if (spec.v.any()) add(table, one ? "speed" : "v", one ? number(spec.v[0]) : list_of(spec.v));
}

}  // namespace

Value::Table describe_joint(const BodySpec& spec, const std::string& name, const std::string& parent) {
  const KindInfo& kind = info(spec.joint.kind);
  Value::Table table;
  if (!name.empty()) add(table, "name", text(name));
  add(table, "kind", text(kind.name));
  if (!parent.empty()) add(table, "parent", text(parent));
  if (kind.axis && !(spec.joint.axis.x == 0 && spec.joint.axis.y == 0 && spec.joint.axis.z > 0))
    add(table, "axis", list(spec.joint.axis));
  if (kind.axis2) add(table, "axis2", list(spec.joint.axis2));
  if (kind.pitch) add(table, "pitch", number(spec.joint.pitch));
  if (Value::Table at = placement(spec.at); !at.empty()) add(table, "at", value(std::move(at)));
  if (Value::Table at = placement(spec.child_at); !at.empty()) add(table, "child_at", value(std::move(at)));
  add_start(table, spec, kind);
  add_parameters(table, spec.joint.parameters, kind);
  return table;
}

Value describe_signal(const Signal& signal) { return signal_value(signal); }

}  // namespace momentree::io
