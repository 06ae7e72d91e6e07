// [[spring]] and [[cable]]: springs and cables between two points of bodies.
#include <momentree/base/characters.hpp>
#include <momentree/io/read_action.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr const char* end_schema = R"({"anyOf": [{"type": "string"}, @]})";

constexpr Key spring_entries[] = {
    {"name", string, "Name, for events and results", nullptr, "name = \"rope\""},
    {"from", other(end_schema, point_table), "Its first end: a point of a body, or of the \"ground\"; a name alone: the origin",
     nullptr, "for example from = { body = \"crane/jib\", point = [2, 0, 0] }"},
    {"to", other(end_schema, point_table), "Its second end", nullptr,
     "for example to = { body = \"ground\", point = [0, 0, 3] }"},
    {"stiffness", number(dimension::force / dimension::length, Range::not_negative), "Stiffness", "0"},
    {"rest", number(dimension::length, Range::not_negative), "Length without force; default: the distance at the start"},
    {"damping", number(dimension::force / dimension::speed, Range::not_negative), "Force per rate of the length", "0"},
    {"tension_only", boolean, "A rope: it pulls and never pushes", "false"},
    {"strength", number(dimension::force, Range::positive), "It breaks when its force exceeds this"},
};

constexpr Key cable_entries[] = {
    {"name", string, "Name, for events and results", nullptr, "name = \"tether\""},
    {"from", other(end_schema, point_table), "Its first end: a point of a body, or of the \"ground\"; a name alone: the origin",
     nullptr, "for example from = { body = \"tug/hull\", point = [1, 0, 0] }"},
    {"to", other(end_schema, point_table), "Its second end", nullptr,
     "for example to = { body = \"ground\", point = [0, 0, 3] }"},
    {"length", number(dimension::length, Range::positive),
     "Its ends are never farther apart; default: the distance at the start"},
    {"restitution", number(dimension::number, Range::not_negative),
     "How its ends rebound when it becomes taut: 0 (not at all) to 1", "0"},
    {"strength", number(dimension::force, Range::positive), "It breaks when its tension exceeds this"},
};

// Names may have one '/', so that springs of a model file carry the name of their mechanism.
bool check_spring_name(const std::string& name, Place place, Diagnostics& out) {
  const std::size_t slash = name.find('/');
  if (slash == std::string::npos) return check_bare_name(name, place, "a spring", out);
  return check_bare_name(name.substr(0, slash), place, "a spring", out) &&
         check_bare_name(name.substr(slash + 1), place, "a spring", out);
}

std::string read_name(Fields& fields, const char* what, Reading& reading) {
  Diagnostics& out = reading.out;
  fields.require("name");
  const auto name = fields.string("name");
  if (!name || !check_spring_name(*name, fields.place_of("name"), out)) return {};
  reading.note(reading.springs, *name, fields.place_of("name"), what);
  if (const auto joint = reading.joints.find(*name); joint != reading.joints.end())
    out.error(fields.place_of("name"),
              "name: there is a joint " + in_quotes(*name) + " already, on " + out.name_of(joint->second),
              "events refer to springs, cables and joints by their names: give the " + std::string(what) + " another one");
  return *name;
}

// The body's name; nothing, with a report, if there is none.
std::optional<std::string> body_of_end(const std::string& name, Place place, const char* key, Reading& reading) {
  if (name == "ground" || reading.bodies.contains(name) || reading.opaque.contains(mechanism_of(name))) return name;
  std::string hint;
  if (means_ground(name)) hint = "the ground is \"ground\"";
  if (hint.empty() && reading.joints.contains(name)) hint = "that is the name of a joint";
  if (hint.empty() && name.find('*') != std::string::npos) hint = "it has two ends: name one body";
  if (hint.empty() && name.find('/') == std::string::npos)
    for (const auto& [mechanism, where] : reading.mechanisms)
      if (reading.bodies.contains(mechanism + "/" + name)) hint = "use the full name: " + in_quotes(mechanism + "/" + name);
  if (hint.empty()) hint = reading.suggest(name, reading.bodies);
  reading.out.error(place, std::string(key) + ": there is no body " + in_quotes(name), std::move(hint));
  return std::nullopt;
}

struct End {
  std::string body;
  Vec3 point{};
};
std::optional<End> read_end(Fields& fields, const char* key, Reading& reading) {
  const Value* value = fields.require(key);
  if (!value) return std::nullopt;
  End end;
  std::optional<std::string> name;
  Place place = value->place;
  const std::size_t errors = reading.out.errors();
  if (value->table()) {
    Fields inner(*value, point_table, reading.out, key);
    if (const Value* body = inner.require("body")) name = read_string(*body, "body", reading.out), place = body->place;
    end.point = inner.vec3("point").value_or(Vec3{});
    inner.finish();
  } else {
    name = read_string(*value, key, reading.out);
  }
  if (!name) return std::nullopt;
  const auto body = body_of_end(*name, place, key, reading);
  if (!body || errors != reading.out.errors()) return std::nullopt;
  end.body = *body;
  return end;
}

}  // namespace

constinit const KeyTable spring_table{"[[spring]]",
                                      "spring",
                                      "A spring or a rope between two points of bodies",
                                      spring_entries,
                                      {{KeyRule::How::some, "stiffness damping"}}};

constinit const KeyTable cable_table{"[[cable]]", "cable", "An inextensible cable between two points of bodies", cable_entries};

namespace {

// Adds it to the model, if its ends are bodies of it and nothing is wrong. `errors`: before the table was read.
void add(const std::optional<End>& from, const std::optional<End>& to, Spring spring, Fields& fields, std::size_t errors,
         Reading& reading) {
  Diagnostics& out = reading.out;
  fields.finish();
  Model& model = reading.scenario.model;
  if (!from || !to || errors != out.errors()) return;
  const auto known = [&](const std::string& body) { return body == "ground" || model.has_body(body); };
  if (!known(from->body) || !known(to->body)) return;  // of a mechanism with errors
  const auto id = [&](const std::string& body) { return body == "ground" ? ground : model.body(body); };
  spring.from = {id(from->body), from->point}, spring.to = {id(to->body), to->point};
  for (SpringProblem& problem : check_spring(spring))
    out.error(fields.place_of(problem.field), problem.field + ": " + problem.what, std::move(problem.hint));
  if (errors != out.errors()) return;
  const double length = norm(start_place(model.bodies(), spring.to) - start_place(model.bodies(), spring.from));
  const std::string what = (spring.inextensible ? "cable " : "spring ") + in_quotes(spring.name);
  if (!(length > 0) && spring.inextensible && !spring.rest) {
    return out.error(fields.place(), what + ": its ends coincide at the start", "give it a length");
  }
  if (!(length > 0) && spring.rest.value_or(0) > 0 && !spring.tension_only && !spring.inextensible)
    out.warning(fields.place(), what + ": its ends coincide at the start: it has no direction there, and exerts no force",
                "move one of the points");
  model.add_spring(std::move(spring));
}

}  // namespace

void read_spring(const Value& table, Reading& reading) {
  const std::size_t errors = reading.out.errors();
  Fields fields(table, spring_table, reading.out);
  Spring spring;
  spring.name = read_name(fields, "spring", reading);
  const auto from = read_end(fields, "from", reading), to = read_end(fields, "to", reading);
  spring.stiffness = fields.number("stiffness").value_or(0);
  spring.rest = fields.number("rest");
  spring.damping = fields.number("damping").value_or(0);
  spring.tension_only = fields.boolean("tension_only").value_or(false);
  spring.strength = fields.number("strength").value_or(spring.strength);
  add(from, to, std::move(spring), fields, errors, reading);
}

void read_cable(const Value& table, Reading& reading) {
  const std::size_t errors = reading.out.errors();
  Fields fields(table, cable_table, reading.out);
  Cable cable;
  cable.name = read_name(fields, "cable", reading);
  const auto from = read_end(fields, "from", reading), to = read_end(fields, "to", reading);
  cable.length = fields.number("length");
  cable.restitution = fields.number("restitution").value_or(0);
  cable.strength = fields.number("strength").value_or(cable.strength);
  add(from, to, spring_of(std::move(cable)), fields, errors, reading);
}

}  // namespace momentree::io
