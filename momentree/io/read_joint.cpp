#include <algorithm>
#include <cmath>

#include <momentree/base/error.hpp>
#include <momentree/io/scenario_parts.hpp>

namespace momentree::io {

namespace {

enum class Quantity { q, v, damping, stiffness, armature, effort, none };

// Of one coordinate or freedom, by the letter that KindInfo has for it.
Dimension dimension_of(Quantity quantity, char letter) {
  using namespace dimension;
  if (quantity == Quantity::q) return letter == 'r' ? angle : letter == 'm' ? length : number;
  const bool turns = letter == 'r';
  const Dimension rate = turns ? angular_speed : speed, effort = turns ? torque : force;
  switch (quantity) {
    case Quantity::damping: return effort / rate;
    case Quantity::stiffness: return turns ? torque / angle : force / length;
    case Quantity::armature: return turns ? inertia : mass;
    case Quantity::effort: return effort;
    case Quantity::none: return number;
    default: return rate;
  }
}

// A list with one number per letter, or, where `single` allows it, one number for all.
Values read_values(const Value& value, Quantity quantity, std::string_view letters, bool single, std::string_view label,
                   Diagnostics& out) {
  Values values;
  if (!value.array()) {
    if (single || letters.size() == 1) {
      // One number for freedoms of different dimension is in SI for each; with a unit it must fit them all.
      std::optional<double> number;
      for (const char letter : letters.empty() ? std::string_view("r") : letters) {
        number = read_number(value, dimension_of(quantity, letter), label, out);
        if (!number) return {};
      }
      values.push_back(*number);
      return values;
    }
    out.error(value.place, std::string(label) + ": expected a list of " + std::to_string(letters.size()) + " numbers, found " +
                               value.type_name());
    return {};
  }
  const Value::Array& entries = *value.array();
  if (entries.size() != letters.size() && !(single && entries.size() == 1)) {
    out.error(value.place,
              std::string(label) + ": expected " + std::to_string(letters.size()) +
                  (letters.size() == 1 ? " number" : " numbers") + ", found a list of " + std::to_string(entries.size()),
              "one per freedom or coordinate, in the order of the kind");
    return {};
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto number = read_number(entries[i], dimension_of(quantity, letters[i]), label, out);
    if (!number) return {};
    values.push_back(*number);
  }
  return values;
}

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const KindInfo& kind : all_kinds()) names.emplace_back(kind.name);
  return names;
}

const KindInfo* read_kind(Fields& fields, Diagnostics& out) {
  std::string all = "one of:";
  for (const std::string& name : kind_names()) all += " " + name;
  const Value* value = fields.require("kind", all);
  const auto name = value ? read_string(*value, "kind", out) : std::nullopt;
  if (!name) return nullptr;
  const KindInfo* kind = find_kind(*name);
  if (kind) return kind;
  const std::string hint = did_you_mean(*name, kind_names());
  out.error(value->place, "unknown joint kind " + in_quotes(*name), hint.empty() ? all : hint);
  return nullptr;
}

// `keeps_axes`: the joint has axes already, which stay where none are given.
void read_geometry(Fields& fields, const KindInfo& kind, bool keeps_axes, JointSpec& joint, Diagnostics& out) {
  const auto takes = [&](const char* key, bool KindInfo::*member) {
    if (kind.*member || !fields.has(key)) return kind.*member;
    fields.find(key);
    std::string hint = "joints that have one:";
    for (const KindInfo& each : all_kinds())
      if (each.*member) hint += " " + std::string(each.name);
    out.error(fields.place_of(key), "a " + std::string(kind.name) + " joint has no '" + key + "'", std::move(hint));
    return false;
  };
  if (takes("axis", &KindInfo::axis)) joint.axis = fields.vec3("axis", dimension::number).value_or(joint.axis);
  if (takes("axis2", &KindInfo::axis2)) {
    // What stands in for a missing one must not be parallel to the first: that would be reported as well.
    const Vec3& a = joint.axis;
    joint.axis2 = std::fabs(a.x) < std::fabs(a.y) + std::fabs(a.z) ? x_axis : y_axis;
    const char* const hint = "the second axis, turned by the first rotation, for example [0, 1, 0]";
    if (const Value* axis2 = keeps_axes ? fields.find("axis2") : fields.require("axis2", hint))
      joint.axis2 = read_vec3(*axis2, dimension::number, "axis2", out).value_or(joint.axis2);
  }
  if (takes("pitch", &KindInfo::pitch)) {
    joint.pitch = 1;
    if (const Value* pitch = fields.require("pitch", "the displacement per turn, for example \"5 mm\""))
      joint.pitch = read_number(*pitch, dimension::length, "pitch", out).value_or(1);
  }
}

void read_start(Fields& fields, const KindInfo& kind, Values& q, Values& v, Diagnostics& out) {
  const Value* list = fields.find("q");
  const Value* rates = fields.find("v");
  if (list) q = read_values(*list, Quantity::q, kind.q_units, false, "q", out);
  if (rates) v = read_values(*rates, Quantity::v, kind.v_units, false, "v", out);
  const bool one = kind.nq == 1 && kind.nv == 1, turns = one && kind.q_units[0] == 'r';
  for (const char* key : {"angle", "position", "speed"}) {
    const Value* value = fields.find(key);
    if (!value) continue;
    const bool rate = key == std::string_view("speed");
    if (!one || (key == std::string_view("angle") && !turns)) {
      out.error(value->place, "a " + std::string(kind.name) + " joint has no '" + key + "'",
                one    ? "its coordinate is a displacement: write 'position'"
                : rate ? "write its velocities as v = […]"
                       : "write its coordinates as q = […]");
      continue;
    }
    Values& target = rate ? v : q;
    if ((rate ? rates != nullptr : list != nullptr) || (key == std::string_view("position") && fields.has("angle"))) {
      out.error(value->place, std::string("'") + key + "' gives the start a second time",
                rate ? "'v' is there too" : "'q' or 'angle' is there too");
      continue;
    }
    target = read_values(*value, rate ? Quantity::v : Quantity::q, rate ? kind.v_units : kind.q_units, true, key, out);
  }
}

void read_drive(const Value& value, const KindInfo& kind, Values& effort, Diagnostics& out) {
  Fields drive(value, "drive", out);
  drive.later({"pd", "motion"});
  if (const Value* given = drive.find("effort")) {
    if (given->table())
      not_supported_yet(given->place, "an effort that changes with time", out);
    else if (!given->array() && kind.nv > 1)
      out.error(given->place,
                "effort: a " + std::string(kind.name) + " joint has " + std::to_string(kind.nv) +
                    " freedoms: one number could mean any",
                "give a list, one effort per freedom");
    else
      effort = read_values(*given, Quantity::effort, kind.v_units, true, "effort", out);
  }
  drive.finish();
}

// One side of a joint's limits: as coordinates, but infinite where there is no stop.
Values read_limit(const Value& value, const KindInfo& kind, const char* key, Diagnostics& out) {
  const auto endless = [](const Value& entry) { return entry.real() && std::isinf(*entry.real()); };
  const Value::Array single{value};
  const Value::Array& entries = value.array() ? *value.array() : single;
  if (std::none_of(entries.begin(), entries.end(), endless)) return read_values(value, Quantity::q, kind.q_units, true, key, out);
  Values all;
  if (value.array() && entries.size() != std::string_view(kind.q_units).size()) {
    read_values(value, Quantity::q, kind.q_units, false, key, out);  // says how many there should be
    return all;
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto number = endless(entries[i]) ? std::optional(*entries[i].real())
                                            : read_number(entries[i], dimension_of(Quantity::q, kind.q_units[i]), key, out);
    if (!number) return {};
    all.push_back(*number);
  }
  return all;
}

void read_limits(const Value& value, const KindInfo& kind, JointLimits& limits, Diagnostics& out) {
  Fields fields(value, "limits", out);
  if (kind.nq != kind.nv || kind.nv == 0) {
    out.error(value.place, "limits: a " + std::string(kind.name) + " joint has no coordinates that could be limited");
    return;
  }
  fields.later({"stiffness", "damping"}, "stops are hard: { lower, upper, restitution }");
  if (const Value* lower = fields.find("lower")) limits.lower = read_limit(*lower, kind, "lower", out);
  if (const Value* upper = fields.find("upper")) limits.upper = read_limit(*upper, kind, "upper", out);
  if (!fields.has("lower") && !fields.has("upper") && value.table())
    out.error(value.place, "limits: neither 'lower' nor 'upper'",
              "for example limits = { lower = \"-90 deg\", upper = \"90 deg\" }");
  if (const Value* e = fields.find("restitution"))
    limits.restitution = read_values(*e, Quantity::none, kind.v_units, true, "restitution", out);
  if (const Value* speed = fields.find("rest_speed")) {
    const Values read = read_values(*speed, Quantity::v, kind.v_units, true, "rest_speed", out);
    if (read.size() > 1)
      out.error(speed->place, "rest_speed: expected one number");
    else if (!read.empty())
      limits.rest_speed = read[0];
  }
  fields.finish();
}

}  // namespace

void read_parameters(Fields& fields, const KindInfo& kind, JointParameters& parameters, Diagnostics& out) {
  const auto per_freedom = [&](const char* key, Quantity quantity, Values& target) {
    if (const Value* value = fields.find(key)) target = read_values(*value, quantity, kind.v_units, true, key, out);
  };
  per_freedom("damping", Quantity::damping, parameters.damping);
  per_freedom("stiffness", Quantity::stiffness, parameters.stiffness);
  per_freedom("armature", Quantity::armature, parameters.armature);
  if (const Value* rest = fields.find("rest"))
    parameters.rest = read_values(*rest, Quantity::q, kind.q_units, false, "rest", out);
  if (const Value* drive = fields.find("drive")) read_drive(*drive, kind, parameters.effort, out);
  if (const Value* limits = fields.find("limits")) read_limits(*limits, kind, parameters.limits, out);
}

void read_plain_parameters(Fields& fields, JointParameters& parameters, Diagnostics& out) {
  const auto read = [&out](const Value& value, const char* key, Values& target) {
    const Value::Array single{value};
    const Value::Array& entries = value.array() ? *value.array() : single;
    if (entries.empty() || entries.size() > Values::capacity)
      return out.error(value.place, std::string(key) + ": expected 1 to " + std::to_string(Values::capacity) + " numbers");
    Values values;
    for (const Value& entry : entries) {
      const auto number = read_number(entry, dimension::number, key, out);
      if (!number) return;
      values.push_back(*number);
    }
    target = values;
  };
  const auto field = [&](const char* key, Values& target) {
    if (const Value* value = fields.find(key)) read(*value, key, target);
  };
  field("damping", parameters.damping);
  field("stiffness", parameters.stiffness);
  field("armature", parameters.armature);
  field("rest", parameters.rest);
  fields.later({"limits"}, "the kind of this joint is not known here");
  if (const Value* value = fields.find("drive")) {
    Fields drive(*value, "drive", out);
    drive.later({"pd", "motion"});
    if (const Value* effort = drive.find("effort")) read(*effort, "effort", parameters.effort);
    drive.finish();
  }
}

namespace {

void warn_of_rest(const Fields& fields, Diagnostics& out) {
  if (fields.has("rest") && !fields.has("stiffness"))
    out.warning(fields.place_of("rest"), "'rest' without 'stiffness' does nothing");
}

// Keys that can't be judged where the kind is not known.
void pass_over(Fields& fields) {
  for (const char* key : {"axis", "axis2", "pitch", "q", "v", "angle", "position", "speed", "damping", "stiffness", "armature",
                          "rest", "drive", "limits"})
    fields.find(key);
}

}  // namespace

void read_joint(const Value& table, BodyEntry& body, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, "[mechanism.body.joint]", out);
  if (!table.table()) return;
  BodySpec& spec = body.spec;
  body.joint = &table;
  if (const auto name = fields.string("name")) {
    if (check_bare_name(*name, fields.place_of("name"), "a joint", out)) body.bare_joint = *name;
  }
  if (const auto parent = fields.string("parent")) body.parent = *parent;
  body.parent_place = fields.place_of("parent");
  body.rooted = !fields.has("parent") || body.parent == "ground";
  spec.at = fields.pose("at").value_or(Pose{});
  spec.child_at = fields.pose("child_at").value_or(Pose{});
  if (const KindInfo* kind = read_kind(fields, out)) {
    spec.joint.kind = kind->kind;
    read_geometry(fields, *kind, false, spec.joint, out);
    read_start(fields, *kind, spec.q, spec.v, out);
    read_parameters(fields, *kind, spec.joint.parameters, out);
    warn_of_rest(fields, out);
  } else {
    pass_over(fields);
  }
  fields.later({"friction", "strength"});
  fields.finish();
}

void read_description(Fields& fields, bool keeps_axes, JointDescription& joint, Diagnostics& out) {
  const std::size_t errors = out.errors();
  const KindInfo* kind = read_kind(fields, out);
  if (!kind) return pass_over(fields);
  joint.spec.kind = kind->kind;
  joint.axis_given = kind->axis && fields.has("axis");
  joint.axis2_given = kind->axis2 && fields.has("axis2");
  read_geometry(fields, *kind, keeps_axes, joint.spec, out);
  read_parameters(fields, *kind, joint.spec.parameters, out);
  warn_of_rest(fields, out);
  if (errors != out.errors()) return;
  // An axis that stays what it is, which is known only then, is none to be parallel to.
  JointSpec judged = joint.spec;
  if (keeps_axes && kind->axis2 && joint.axis2_given && !joint.axis_given)
    judged.axis = std::fabs(judged.axis2.x) < std::fabs(judged.axis2.y) + std::fabs(judged.axis2.z) ? x_axis : y_axis;
  report_problems(judged, fields, out);
}

bool report_problems(const JointSpec& joint, const Fields& fields, Diagnostics& out) {
  const std::size_t errors = out.errors();
  for (const JointProblem& problem : check_joint(joint))
    out.error(fields.place_of(problem.field), problem.field + ": " + problem.what, problem.hint);
  return errors != out.errors();
}

void read_joint_state(const Value& value, std::string_view joint, BodySpec& spec, Diagnostics& out) {
  const KindInfo& kind = info(spec.joint.kind);
  if (value.table()) {
    Fields fields(value, in_quotes(joint), out);
    read_start(fields, kind, spec.q, spec.v, out);
    fields.finish();
  } else {
    spec.q = read_values(value, Quantity::q, kind.q_units, false, joint, out);
  }
  for (const BodyProblem& problem : check_body(spec)) {
    Values& wrong = problem.field == "q" ? spec.q : spec.v;
    if (problem.field != "q" && problem.field != "v") continue;
    out.error(value.place, std::string(joint) + ": " + problem.what, problem.hint);
    wrong = {};
  }
}

}  // namespace momentree::io
