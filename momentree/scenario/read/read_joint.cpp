#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>

#include <momentree/base/error.hpp>
#include <momentree/scenario/keys/dof_values.hpp>
#include <momentree/scenario/mistakes/shapes.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

using namespace type;

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const KindInfo& kind : all_kinds()) names.emplace_back(kind.name);
  return names;
}

std::vector<std::string> loop_kind_names() {
  std::vector<std::string> names = kind_names();
  std::erase(names, info(Kind::free).name);
  return names;
}

constexpr Key geometry_entries[] = {
    {"kind", choice(&kind_names), "Kind of joint", nullptr, ""},
    {"axis", vector(dimension::number), "Axis in the joint's frame, of any length but zero", "[0, 0, 1]", nullptr,
     &KindInfo::axis},
    {"axis2", vector(dimension::number), "Second axis, turned by the first rotation", nullptr, nullptr, &KindInfo::axis2},
    {"pitch", number(dimension::length), "Displacement per turn", nullptr, nullptr, &KindInfo::pitch},
};

constexpr Key loop_geometry_entries[] = {{"kind", choice(&loop_kind_names), "Kind of joint", nullptr, ""},
                                         geometry_entries[1],
                                         geometry_entries[2],
                                         geometry_entries[3]};

// One number, or a list; quaternions count as coordinates.
constexpr const char* coordinates =
    R"({"anyOf": [{"type": ["number", "string"]}, {"type": "array", "items": {"type": ["number", "string"]}, "maxItems": 7}]})";
constexpr Key starts_entries[] = {
    {"q", other(coordinates), "Initial coordinates in the order of the kind, in rad and m; quaternions are w, x, y, z"},
    {"v", other(coordinates), "Initial velocities in the order of the kind, in rad/s and m/s"},
    {"angle", number(dimension::angle), "Initial angle of a joint with one DoF"},
    {"position", number("rad or m"), "Initial position of a joint with one DoF"},
    {"speed", number("rad/s or m/s"), "Initial speed of a joint with one DoF"},
};

constexpr Key own_entries[] = {
    {"name", string, "Name within the mechanism; default: that of the body"},
    {"parent", string, "Parent body; \"ground\", or no key: the ground"},
    {"at", table(placement_table), "Placement of the joint's frame in the parent's frame"},
    {"child_at", table(placement_table), "Placement of the joint's frame in the body's frame"},
};

const KindInfo* read_kind(Fields& fields, Diagnostics& out) {
  std::string all = "one of:";
  for (const std::string& name : kind_names()) all += " " + name;
  const Value* value = fields.require("kind", all);
  const auto name = value ? read_string(*value, "kind", out) : std::nullopt;
  if (!name) return nullptr;
  const KindInfo* kind = find_kind(*name);
  if (kind) return kind;
  std::string hint = cure_of_kind(*name);
  if (hint.empty()) hint = did_you_mean(*name, kind_names());
  out.error(value->place, "unknown joint kind " + in_quotes(*name), hint.empty() ? all : hint);
  return nullptr;
}

// `keeps_axes`: the joint already has axes, which stay unchanged if none are given.
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
    // The default for a missing axis must not be parallel to the first: that would be reported as well.
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

void warn_of_rest(const Fields& fields, Diagnostics& out) {
  if (fields.has("rest") && !fields.has("stiffness"))
    out.warning(fields.place_of("rest"), "'rest' without 'stiffness' has no effect");
}

std::optional<Place> first_of(const Fields& fields, std::initializer_list<const char*> keys) {
  for (const char* key : keys)
    if (fields.has(key)) return fields.place_of(key);
  return {};
}

// Skips keys that cannot be checked if the kind is unknown.
void pass_over(Fields& fields) {
  for (const KeyList& list : {joint_geometry, joint_starts})
    for (const Key& key : list) fields.find(key.name);
  for (const JointKey& key : joint_keys())
    if (!key.documents) fields.find(key.key);
}

}  // namespace

constinit const KeyList joint_geometry = geometry_entries, loop_geometry = loop_geometry_entries, joint_starts = starts_entries;
constinit const KeyTable joint_table{"[mechanism.body.joint]",         "joint", "The inboard joint of a body", own_entries, {},
                                     {&joint_geometry, &joint_starts}, true};
constinit const KeyTable joint_start_table{"start", "joint_start", "Initial values of a joint", starts_entries};

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
    if (const Value::Array* place = value->array(); place && place->size() == 3 && key == std::string_view("position")) {
      out.error(value->place, "position: expected the joint's coordinate, found a list of 3",
                "a joint is placed by its `at`; write at = { xyz = " + as_written(*value) + " }");
      continue;
    }
    Values& target = rate ? v : q;
    if ((rate ? rates != nullptr : list != nullptr) || (key == std::string_view("position") && fields.has("angle"))) {
      out.error(value->place, std::string("'") + key + "' gives the initial value a second time",
                rate ? "'v' is given, too" : "'q' or 'angle' is given, too");
      continue;
    }
    target = read_values(*value, rate ? Quantity::v : Quantity::q, rate ? kind.v_units : kind.q_units, true, key, out);
  }
}

void start_motion(BodySpec& spec, const std::optional<Place>& q, const std::optional<Place>& v, Diagnostics& out) {
  auto& drive = spec.joint.parameters.drive;
  if (!drive || drive->motion.size() != 1 || info(spec.joint.kind).nv != 1) return;
  begin_motion(drive, spec.q.size() == 1 ? spec.q[0] : 0, 0);
  const Curve::Point start = drive->motion[0].at(0);
  const auto check = [&out](const Values& given, const std::optional<Place>& place, double is, const char* what) {
    if (!place || given.size() != 1 || std::fabs(given[0] - is) <= 1e-9 * std::max(1.0, std::fabs(is))) return;
    out.error(*place,
              std::string("the joint's motion starts at the ") + what + " " + rounded_text(is, 9) + ", not " +
                  rounded_text(given[0], 9),
              std::string("leave the start ") + what + " out: the motion gives it");
  };
  check(spec.q, q, start.value, "position");
  check(spec.v, v, start.rate, "speed");
  spec.q = start.value, spec.v = start.rate;
}

void read_joint(const Value& table, BodyEntry& body, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, joint_table, out);
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
    read_parameters(fields, kind, spec.joint.parameters, out);
    start_motion(spec, first_of(fields, {"q", "angle", "position"}), first_of(fields, {"v", "speed"}), out);
    warn_of_rest(fields, out);
  } else {
    pass_over(fields);
  }
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
  read_parameters(fields, kind, joint.spec.parameters, out);
  warn_of_rest(fields, out);
  if (errors != out.errors()) return;
  // An axis that stays unchanged is known only later, so it is not checked for being parallel.
  JointSpec checked = joint.spec;
  if (keeps_axes && kind->axis2 && joint.axis2_given && !joint.axis_given)
    checked.axis = std::fabs(checked.axis2.x) < std::fabs(checked.axis2.y) + std::fabs(checked.axis2.z) ? x_axis : y_axis;
  report_problems(checked, fields, out);
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
    Fields fields(value, joint_start_table, out, in_quotes(joint));
    read_start(fields, kind, spec.q, spec.v, out);
    start_motion(spec, first_of(fields, {"q", "angle", "position"}), first_of(fields, {"v", "speed"}), out);
    fields.finish();
  } else {
    spec.q = read_values(value, Quantity::q, kind.q_units, false, joint, out);
    start_motion(spec, value.place, std::nullopt, out);
  }
  for (const BodyProblem& problem : check_body(spec)) {
    Values& wrong = problem.field == "q" ? spec.q : spec.v;
    if (problem.field != "q" && problem.field != "v") continue;
    out.error(value.place, std::string(joint) + ": " + problem.what, problem.hint);
    wrong = {};
  }
}

}  // namespace momentree::io
