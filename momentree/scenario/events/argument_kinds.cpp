// Each kind of argument: how it is read, and what describes it. A new kind is two functions, and an entry in the list at the end.
#include <momentree/scenario/events/argument_kinds.hpp>

#include <algorithm>
#include <array>

#include <momentree/scenario/events/argument_reader.hpp>
#include <momentree/scenario/events/joint_fields.hpp>
#include <momentree/scenario/keys/described.hpp>
#include <momentree/simulate/contact/contact_bodies.hpp>

namespace momentree::io {

namespace {

void read(const Argument& a, const argument::Joint& joint, ArgumentReader& in) {
  const Value* const given = in.find(a.key, true);
  const auto text = in.text(given, a.key);
  if (!text) return;
  joint.name = in.matched(*text, &TriggerMatch::joint);
  if (in.matches(*text)) return;
  in.reading.joint_uses.push_back({joint.name, in.key, given->place, in.time, sets_parameters(in.what), in.what.takes_springs()});
}
ArgumentDescription described(const Argument& a, const argument::Joint&) {
  const bool own = a.field.about != nullptr;
  return {{{a.key, type::string, own ? a.field.about : "Full name of a joint; * matches within a name", nullptr, ""}},
          {{a.key, "JointName", own ? "Its name, or its handle" : "Name of the joint, or its handle"}}};
}

void read(const Argument& a, const argument::MadeJoint& joint, ArgumentReader& in) {
  const Value* const given = in.find(a.key);
  const auto text = in.text(given, a.key);
  // it may be in a mechanism: "tug/clasp"
  if (!text || !check_bare_name(text->substr(text->rfind('/') + 1), given->place, "a joint", in.out)) return;
  if (!in.wild())
    joint.name = *text;
  else
    in.error(*given, "joints that a wildcard makes can't all be named " + in_quotes(*text),
             "leave out the name: each is then named after its bodies");
}
ArgumentDescription described(const Argument& a, const argument::MadeJoint&) {
  return {{{a.key, type::string, R"(Full name of the joint that this makes; default: that of the event, or else "<to>+<body>")"}},
          {{a.key, "str | None = None",
            "Name of the joint that this makes, for later actions; default: that of the event, or else ``to+body``", true}}};
}

void check_body(const char* key, const std::string& name, const Value& given, ArgumentReader& in) {
  Reading& reading = in.reading;
  if (name.find('*') != std::string::npos)
    return in.error(given, "'" + std::string(key) + "' is one body: " + in_quotes(name) + " can match several");
  if (reading.bodies.contains(name) || reading.opaque.contains(mechanism_of(name))) return;
  std::string hint = reading.joints.contains(name) ? "that is the name of a joint" : "";
  if (hint.empty() && name.find('/') == std::string::npos)
    for (const auto& [mechanism, where] : reading.mechanisms)
      if (reading.bodies.contains(mechanism + "/" + name)) hint = "use the full name: " + in_quotes(mechanism + "/" + name);
  if (hint.empty()) hint = reading.suggest(name, reading.bodies);
  if (hint.empty() && means_ground(name)) hint = "the ground is \"ground\"";
  in.error(given, "there is no body " + in_quotes(name), std::move(hint));
}

void read(const Argument& a, const argument::Body& body, ArgumentReader& in) {
  const Value* const given = in.find(a.key, true);
  const auto text = in.text(given, a.key);
  if (!text) return;
  body.name = in.matched(*text, &TriggerMatch::body);
  if (body.name == "ground")
    in.error(*given, "this action cannot be applied to the ground",
             in.value.find("to") ? "the ground can only be the body that another is joined 'to'" : "");
  else if (!in.matches(*text))
    check_body(a.key, body.name, *given, in);
}
ArgumentDescription described(const Argument& a, const argument::Body&) {
  return {{{a.key, type::string, "Full name of a body", nullptr, ""}}, {{a.key, "BodyName", "Name of the body, or its handle"}}};
}

void read(const Argument& a, const argument::OtherBody& body, ArgumentReader& in) {
  const Value* const given = in.find(a.key);
  body.name = in.text(given, a.key).value_or("ground");
  if (body.name != "ground") check_body(a.key, body.name, *given, in);
}
ArgumentDescription described(const Argument& a, const argument::OtherBody&) {
  return {{{a.key, type::string, R"(Full name of a body, or "ground", the default)"}},
          {{a.key, R"(BodyName = "ground")", "Name or handle of the other body, or ``\"ground\"``"}}};
}

void read(const Argument& a, const argument::Mechanism& mechanism, ArgumentReader& in) {
  const Value* const given = in.given(a.key);
  const auto text = in.text(given, a.key);
  if (!text) return;
  mechanism.name = *text;
  // A separated part becomes a mechanism named after its root body.
  if (!in.reading.mechanisms.contains(*text) && !in.reading.bodies.contains(*text))
    in.error(*given, "there is no mechanism " + in_quotes(*text), in.reading.suggest(*text, in.reading.mechanisms));
}
ArgumentDescription described(const Argument& a, const argument::Mechanism&) {
  return {{{a.key, type::string, "Name of a mechanism", nullptr, ""}}, {{a.key, "str", "Name of the mechanism"}}};
}

void read(const Argument& a, const argument::Component& component, ArgumentReader& in) {
  if (!in.table())
    return in.error(in.value, "names no component",
                    "write reaction = { joint = …, component = \"fx\" }, or reaction_force for the norm");
  const Value* const given = in.find(a.key, true);
  const auto text = given ? read_string(*given, a.key, in.out) : std::nullopt;
  if (!text) return;
  if (text->size() != 2 || std::string("fm").find((*text)[0]) == std::string::npos ||
      std::string("xyz").find((*text)[1]) == std::string::npos)
    return in.out.error(given->place, std::string(a.key) + ": there is no " + in_quotes(*text), "one of: fx fy fz mx my mz");
  component.name = *text;
}
ArgumentDescription described(const Argument& a, const argument::Component&) {
  return {{{a.key, type::choice("fx|fy|fz|mx|my|mz"), "Component", nullptr, ""}}, {{a.key, "Component", "The component"}}};
}

// The entries of a list of two; null, with a report, if it is something else.
const Value* two_entries(const Argument& a, const char* what, const char* hint, ArgumentReader& in) {
  const Value* const given = in.given(a.key);
  if (given && given->array() && given->array()->size() == 2) return given->array()->data();
  if (given) in.error(*given, std::string("expected a list of two ") + what, hint);
  return nullptr;
}

void read_solid(const Value& entry, std::string& name, ArgumentReader& in) {
  Reading& reading = in.reading;
  const auto text = read_string(entry, in.key, in.out);
  if (!text) return;
  name = *text == "floor" ? "ground" : in.matched(*text, &TriggerMatch::body);
  if (name == "ground" || reading.bodies.contains(name) || reading.mechanisms.contains(name)) return;
  if (!ContactBodies(reading.scenario.model, name).empty()) return;  // a mechanism that has broken
  std::string hint = reading.suggest(name, reading.bodies);
  if (hint.empty()) hint = reading.suggest(name, reading.mechanisms);
  in.error(entry, "there is no body or mechanism " + in_quotes(name), std::move(hint));
}
void read(const Argument& a, const argument::TwoSolids& solids, ArgumentReader& in) {
  const Value* const entries = two_entries(a, "bodies or mechanisms", "for example [\"crate\", \"floor\"]", in);
  if (entries) read_solid(entries[0], solids.one, in), read_solid(entries[1], solids.other, in);
}
ArgumentDescription described(const Argument& a, const argument::TwoSolids&) {
  constexpr Type two = type::other(
      R"({"type": "array", "items": {"description": "Name of a mechanism, which stands for any of its bodies, full name of a )"
      R"(body, \"ground\" or \"floor\"; * matches within the name of a body", "type": "string"}, "minItems": 2, "maxItems": 2})");
  return {
      {{a.key, two, "", nullptr, ""}},
      {{"one", "BodyName",
        "Name or handle of a body with a collision; name of a mechanism, which stands for any of its bodies; or ``\"ground\"``"},
       {"other", "BodyName", "The other one"}},
      "[one, other]"};
}

void read_point(const Value& entry, const argument::Point& to, bool ground_too, ArgumentReader& in) {
  const Value* name = &entry;
  std::optional<std::string> text;
  if (entry.table()) {
    Fields fields(entry, point_table, in.out, in.key);
    name = fields.require("body");
    if (name) text = read_string(*name, "body", in.out);
    to.point = fields.vec3("point").value_or(Vec3{});
    fields.finish();
  } else {
    text = read_string(entry, in.key, in.out);
  }
  if (!text) return;
  to.body = in.matched(*text, &TriggerMatch::body);
  if ((!ground_too || to.body != "ground") && !in.reading.bodies.contains(to.body))
    in.error(*name, "there is no body " + in_quotes(to.body), in.reading.suggest(to.body, in.reading.bodies));
}
void read(const Argument& a, const argument::Point& point, ArgumentReader& in) {
  if (const Value* const given = in.given(a.key)) read_point(*given, point, false, in);
}
ArgumentDescription described(const Argument& a, const argument::Point&) {
  return {
      {{a.key, body_point, "", nullptr, ""}},
      {{"body", "BodyName", "Name of the body, or its handle"}, {"point", "Vector = (0, 0, 0)", "Point in the body's frame (m)"}},
      R"({"body": body, "point": point})"};
}

void read(const Argument& a, const argument::TwoPoints& points, ArgumentReader& in) {
  const Value* const entries = two_entries(a, "bodies", "for example [\"tug/gripper\", \"satellite/hull\"]", in);
  if (entries) read_point(entries[0], points.one, true, in), read_point(entries[1], points.other, true, in);
}
ArgumentDescription described(const Argument& a, const argument::TwoPoints&) {
  constexpr Type two =
      type::other(R"({"type": "array", "items": {"anyOf": [{"type": "string"}, @]}, "minItems": 2, "maxItems": 2})", point_table);
  return {{{a.key, two, "", nullptr, ""}},
          {{"one", "BodyName", "Name or handle of a body"},
           {"other", "BodyName", "Name or handle of the other, or ``\"ground\"``"},
           {"point_of_one", "Vector = (0, 0, 0)", "Point in its frame (m)"},
           {"point_of_other", "Vector = (0, 0, 0)", "Point in its frame (m)"}},
          R"([{"body": one, "point": point_of_one}, {"body": other, "point": point_of_other}])"};
}

// As docstrings have it, with the unit.
std::string in_python(const Field& field) {
  std::string text;
  for (const char* c = field.about; *c != '\0'; ++c) text += *c == '`' ? "``" : std::string(1, *c);
  const std::string unit = unit_of(field.dimension);
  return unit.empty() ? text : text + " (" + unit + ")";
}

void read(const Argument& a, double& value, ArgumentReader& in) {
  const Value* const given = in.find(a.key, true);
  const auto number = given ? read_number(*given, a.field.dimension, a.key, in.out) : std::nullopt;
  if (!number) return;
  if (a.field.range == Range::any || *number > 0 || (a.field.range == Range::not_negative && *number == 0))
    value = *number;
  else
    in.out.error(given->place,
                 a.key + std::string(a.field.range == Range::positive ? ": must be greater than 0" : ": must not be negative"));
}
ArgumentDescription described(const Argument& a, const double&) {
  return {{{a.key, type::number(a.field.dimension, a.field.range), a.field.about, nullptr, ""}},
          {{a.key, "Number", in_python(a.field)}}};
}

void read(const Argument& a, Vec3& value, ArgumentReader& in) {
  const Value* const given = in.find(a.key);
  if (!(a.field.dimension == dimension::length)) in.effect(given != nullptr);  // part of a wrench
  if (given) value = read_vec3(*given, a.field.dimension, a.key, in.out).value_or(value);
}
ArgumentDescription described(const Argument& a, const Vec3&) {
  return {{{a.key, type::vector(a.field.dimension), a.field.about, "[0, 0, 0]"}},
          {{a.key, "Vector | None = None", in_python(a.field), true}}};
}

void read(const Argument& a, std::optional<Pose>& value, ArgumentReader& in) {
  if (const Value* const given = in.find(a.key)) value = read_pose(*given, a.key, in.out);
}
ArgumentDescription described(const Argument& a, const std::optional<Pose>&) {
  return {{{a.key, type::table(placement_table), a.field.about}},
          {{a.key, "Pose | None = None", in_python(a.field) + "; by default where the body is", true}},
          "pose(" + std::string(a.key) + ")"};
}

void read(const Argument& a, const argument::Dofs& dofs, ArgumentReader& in) {
  const char* const hint = "degrees of freedom are numbered in the order of v: [0, 2]";
  const Value* const list = in.find(a.key);
  if (!list) return;
  const auto error = [&](const Value& at, const std::string& what, const char* how = "") {
    in.out.error(at.place, a.key + (": " + what), how);
  };
  if (!list->array()) return error(*list, std::string("expected a list, found ") + list->type_name(), hint);
  if (list->array()->empty()) error(*list, "names no degree of freedom", "leave it out for all of them");
  unsigned seen = 0;
  for (const Value& entry : *list->array()) {
    const std::int64_t* number = entry.integer();
    if (!number || *number < 0 || *number > 5) {
      const std::string found = number ? ", not " + std::to_string(*number) : std::string(", found ") + entry.type_name();
      error(entry, "expected a number from 0 to 5" + found, hint);
    } else if ((seen >> *number & 1u) != 0) {
      error(entry, std::to_string(*number) + " is given twice");
    } else {
      seen |= 1u << *number;
      dofs.numbers.push_back(static_cast<int>(*number));
    }
  }
}
ArgumentDescription described(const Argument& a, const argument::Dofs&) {
  constexpr Type numbers =
      type::other(R"({"type": "array", "items": {"type": "integer", "minimum": 0, "maximum": 5}, "minItems": 1})");
  return {{{a.key, numbers, "DoFs, numbered from 0 in the order of v; default: all of them"}},
          {{a.key, "Sequence[int] | None = None", "Indices of degrees of freedom in the order of v; all of them if left out"}}};
}

void read(const Argument&, const argument::Description& description, ArgumentReader& in) {
  if (Fields* table = in.table()) read_description(*table, description.keeps_axes, description.joint, in.out);
}
ArgumentDescription described(const Argument& a, const argument::Description&) {
  return {{joint_geometry.begin(), joint_geometry.end()},
          {{a.key, "JointSpec", "The joint: :func:`Revolute`, :func:`Ball` …"}},
          "**" + std::string(a.key) + ".scenario_value()",
          true};
}

void read_for(const KindInfo* kind, Fields& fields, JointParameters& parameters, Diagnostics& out) {
  const std::size_t errors = out.errors();
  read_parameters(fields, kind, parameters, out);
  if (!kind || errors != out.errors()) return;
  JointSpec spec;
  spec.kind = kind->kind, spec.axis2 = x_axis, spec.pitch = 1, spec.parameters = parameters;
  report_problems(spec, fields, out);
}
// True if the parameters are possible for joints of that kind.
bool fit(const KindInfo* kind, const ArgumentReader& in) {
  Diagnostics problems("", "");
  Fields fields(in.value, in.key, problems);
  JointParameters parameters;
  read_for(kind, fields, parameters, problems);
  return problems.errors() == 0;
}
void read(const Argument&, const argument::Parameters& parameters, ArgumentReader& in) {
  if (!in.table()) return;
  Fields& table = *in.table();
  bool any = false;
  for (const JointKey& key : joint_keys()) any = any || (!key.documents && table.has(key.key));
  in.effect(any);
  const std::vector<const KindInfo*> kinds = in.kinds_of ? in.kinds_of(parameters.of) : std::vector<const KindInfo*>();
  const KindInfo* kind = kinds.empty() ? nullptr : kinds.front();
  if (kinds.size() > 1) {
    const auto fitting = std::find_if(kinds.begin(), kinds.end(), [&](const KindInfo* each) { return fit(each, in); });
    if (fitting != kinds.end()) kind = *fitting;
  }
  if (in.wild() && kind && kind->nv == 0) {  // a weld among the matches has at most a strength
    Diagnostics ignored("", "");
    Fields again(in.value, in.key, ignored);
    JointParameters all;
    read_parameters(again, nullptr, all, ignored);
    parameters.values.strength = all.strength;
    for (const JointKey& key : joint_keys()) static_cast<void>(table.find(key.key));
    return;
  }
  if (!kind && in.out.errors() > 0) {  // it may be one of the joints that could not be read
    for (const JointKey& key : joint_keys()) static_cast<void>(table.find(key.key));
    return;
  }
  read_for(kind, table, parameters.values, in.out);
}
ArgumentDescription described(const Argument&, const argument::Parameters&) { return {.parameters = true}; }

template <class... T>
std::array<ArgumentKind, sizeof...(T)> list_of_kinds() {
  return {ArgumentKind{&typeid(T), [](const Argument& a, ArgumentReader& in) { read(a, *a.as<T>(), in); },
                       [](const Argument& a) { return described(a, *a.as<T>()); },
                       [](ArchiveWriter& archive, const Argument& a) { archive(*a.as<T>()); },
                       [](ArchiveReader& archive, const Argument& a) { archive(*a.as<T>()); }}...};
}

}  // namespace

const ArgumentKind& kind_of(const Argument& argument) {
  namespace of = momentree::argument;
  static const auto all =
      list_of_kinds<of::Joint, of::MadeJoint, of::Body, of::OtherBody, of::Mechanism, of::Component, of::TwoSolids, of::Point,
                    of::TwoPoints, of::Dofs, double, Vec3, std::optional<Pose>, of::Description, of::Parameters>();
  const auto found = std::find_if(all.begin(), all.end(), [&](const ArgumentKind& kind) { return *kind.type == *argument.type; });
  MT_REQUIRE(found != all.end(), "the list has every kind of argument");
  return *found;
}

}  // namespace momentree::io
