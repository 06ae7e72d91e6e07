// What bodies touch with, the floor, and [[contact]]: the laws of contacts.
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <utility>

#include <momentree/contact/shapes/height_field.hpp>
#include <momentree/math/unit.hpp>
#include <momentree/models/import/height_grid.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/contact/contact_bodies.hpp>
#include <momentree/simulate/stepping/overlap.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr const char* friction_schema = R"({"anyOf": [{"type": ["number", "string"]}, @]})";

constexpr Key friction_entries[] = {
    {"static", number(dimension::number, Range::not_negative), "Coefficient up to which a contact sticks"},
    {"kinetic", number(dimension::number, Range::not_negative), "Coefficient while it slips", nullptr, ""},
    {"torsional", number(dimension::length, Range::not_negative), "Largest moment about the normal over the normal force", "0"},
    {"rolling", number(dimension::length, Range::not_negative), "The same about the tangents: rolling resistance", "0"},
};
constexpr KeyTable friction_table{"friction", "", "Friction of slip, of spin and of rolling", friction_entries};

constexpr Key belt_entries[] = {
    {"axis", vector(dimension::number), "Around which the surface runs; of a body in its own axes", nullptr,
     "for example axis = [0, 1, 0], around which the upper side runs along x"},
    {"speed", number(dimension::speed), "Of the surface, relative to its body", nullptr, "for example speed = 0.5"},
};

constexpr Key floor_entries[] = {
    {"height", number(dimension::length), "Height of the floor along its normal", "0"},
    {"normal", vector(dimension::number), "Its normal; default: against gravity"},
    {"friction", other(friction_schema, friction_table), "Friction of bodies on the floor", "0.5"},
    {"restitution", number(dimension::number, Range::not_negative), "Restitution of bodies on the floor, 0 to 1", "0"},
    {"belt", table(belt_table), "The floor runs"},
};

constexpr Key contact_entries[] = {
    {"name", string, "Name, for its events: \"impact NAME\""},
    {"between", other(R"({"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2})"),
     "Two names of bodies or mechanisms, \"ground\" or \"floor\"; * stands for any part of a name; default: all with all"},
    {"friction", other(friction_schema, friction_table), "A coefficient, or a table of several", "0.5"},
    {"restitution", number(dimension::number, Range::not_negative), "0 (plastic) to 1 (elastic)", "0"},
    {"off", boolean, "They pass through each other", "false"},
};

void read_friction(Fields& fields, ContactLaw& law, Reading& reading) {
  const Value* value = fields.find("friction");
  if (value == nullptr) return;
  if (value->table()) {
    Fields inner(*value, friction_table, reading.out, "friction");
    inner.require("kinetic");
    law.friction = inner.number("kinetic").value_or(law.friction);
    law.static_friction = inner.number("static").value_or(law.friction);
    law.torsional = inner.number("torsional").value_or(0), law.rolling = inner.number("rolling").value_or(0);
    if (law.static_friction < law.friction)
      reading.out.error(value->place, "friction: the static coefficient can't be smaller than the kinetic one");
    inner.finish();
  } else if (const auto mu = read_number(*value, dimension::number, "friction", reading.out)) {
    law.friction = law.static_friction = *mu;
    if (*mu < 0) reading.out.error(value->place, "friction: a coefficient can't be negative");
  }
}

void read_law(Fields& fields, ContactLaw& law, Reading& reading) {
  read_friction(fields, law, reading);
  law.restitution = fields.number("restitution").value_or(0);
  if (law.restitution > 1)
    reading.out.error(fields.place_of("restitution"), "restitution: at most 1: an impact can't gain energy");
}

// The bodies of one name of `between`; empty with a report if there are none. Writes the name unless it is that of the ground.
std::vector<BodyId> bodies_of(const Value& value, Reading& reading, std::string& written) {
  const auto name = read_string(value, "between", reading.out);
  if (!name) return {};
  if (*name == "ground" || *name == "floor") return {ground};
  const Model& model = reading.scenario.model;
  std::vector<BodyId> all;
  for (int b = 0; b < model.size(); ++b)
    if (names_body(*name, model[BodyId{b}].name)) all.push_back({b});
  written = *name;
  if (!all.empty() || reading.opaque.contains(mechanism_of(*name))) return all;
  if (reading.bodies.contains(*name) || reading.mechanisms.contains(*name)) return {};  // left out after an error
  std::string hint = reading.suggest(*name, reading.bodies);
  if (hint.empty()) hint = reading.suggest(*name, reading.mechanisms);
  reading.out.error(value.place, "between: there is no body or mechanism " + in_quotes(*name), std::move(hint));
  return {};
}

ShapeReports reports_at(Place place, Diagnostics& out) {
  const auto error = [place, &out](const std::string& what, const std::string& hint) {
    out.error(place, "collision: " + what, hint);
  };
  const auto warn = [place, &out](const std::string& what, const std::string& hint) {
    out.warning(place, "collision: " + what, hint);
  };
  return {error, warn, error, error};
}

// What is noted of the shape from which a solid was made.
Shape shape_of_part(const Shape& shape, std::size_t number) {
  Shape noted;
  if (number > 0) {
    noted.part = true;
  } else {
    noted = shape;
    noted.more.clear(), noted.colour.clear();
  }
  return noted;
}

std::string text_of_length(double metres) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g m", metres);
  return text;
}

}  // namespace

constinit const KeyTable contact_table{"[[contact]]", "contact", "Friction and restitution of contacts", contact_entries};
constinit const KeyTable floor_table{"floor", "", "A plane with the ground below it", floor_entries};
constinit const KeyTable belt_table{"belt", "belt", "The surface runs, as that of a conveyor belt, a roller or a track",
                                    belt_entries};

Vec3 read_belt(const Value& value, Diagnostics& out) {
  Fields fields(value, belt_table, out, "belt");
  fields.require("axis"), fields.require("speed");
  const Vec3 axis = fields.vec3("axis").value_or(z_axis);
  const double speed = fields.number("speed").value_or(0);
  fields.finish();
  if (axis != Vec3{}) return speed * unit(axis);
  out.error(fields.place_of("axis"), "axis: must not be zero");
  return {};
}

void read_collision(const Value& value, BodyEntry& body, Reading& reading) {
  const auto add = [&](const Shape& shape) {
    if (shape.kind == Shape::Kind::none) return;  // reported already
    std::vector<contact::Solid> solids = solids_of(shape, reports_at(value.place, reading.out));
    for (std::size_t i = 0; i < solids.size(); ++i) body.collision_shapes.push_back(shape_of_part(shape, i));
    std::move(solids.begin(), solids.end(), std::back_inserter(body.collision));
  };
  const auto add_all = [&](const Shape& shape) {
    add(shape);
    for (const Shape& more : shape.more) add(more);
  };
  const std::string* const word = value.string();
  if (word == nullptr) {
    add_all(read_shape(value, reading, ShapeUse::body));
  } else if (*word == "shape") {
    if (body.shape.kind == Shape::Kind::none)
      reading.out.error(value.place, "collision: the body has no shape", "give it one, or a list of shapes as its collision");
    else
      add_all(body.shape);
  } else if (*word != "none") {
    reading.out.error(value.place, "collision: expected shapes, \"shape\" or \"none\", not " + in_quotes(*word));
  }
}

void add_colliders(BodyId body, const std::vector<contact::Solid>& solids, Model& model) {
  for (const contact::Solid& solid : solids) {
    Collider collider;
    collider.body = body, collider.solid = solid;
    model.add_collider(std::move(collider));
  }
}

std::vector<Collider> ground_colliders(Shape shape, const Pose& pose, const ShapeReports& report) {
  Collider collider;
  shape.at = pose * shape.at;
  if (shape.kind == Shape::Kind::plane) {
    collider.plane = true;
    collider.point = shape.at.position, collider.normal = unit(rotation_matrix(shape.at.rotation) * shape.size);
    return {collider};
  }
  if (shape.kind == Shape::Kind::heights) {
    std::vector<double> heights = shape.heights->values;
    for (double& height : heights) height *= shape.size.z;
    collider.field = std::make_shared<const contact::HeightField>(contact::height_field(
        shape.size.x, shape.size.y, shape.heights->columns, shape.heights->rows, std::move(heights), shape.at));
    return {collider};
  }
  std::vector<Collider> all;
  for (contact::Solid& solid : solids_of(shape, report)) all.emplace_back().solid = std::move(solid);
  return all;
}

void read_ground(const Value& value, Reading& reading) {
  Scenario& scenario = reading.scenario;
  const std::size_t errors = reading.out.errors();
  const Shape all = read_shape(value, reading, ShapeUse::ground);
  if (errors != reading.out.errors()) return;
  const auto add = [&](const Shape& shape) {
    std::size_t part = 0;
    for (Collider& collider : ground_colliders(shape, {}, reports_at(value.place, reading.out))) {
      scenario.model.add_collider(std::move(collider));
      note_collision_shapes(scenario.model, {shape_of_part(shape, part++)}, scenario.collision_shapes);
    }
  };
  add(all);
  for (const Shape& more : all.more) add(more);
}

void read_floor(const Value& value, Reading& reading) {
  Model& model = reading.scenario.model;
  const double g = norm(model.gravity());
  Collider floor;
  floor.plane = true;
  if (g > 0) floor.normal = (-1 / g) * model.gravity();
  ContactRule rule;
  rule.other = {ground};
  if (const bool* const there = value.boolean()) {
    if (*there) model.add_collider(floor);
    return;
  }
  const std::size_t errors = reading.out.errors();
  Fields fields(value, floor_table, reading.out, "floor");
  if (const auto normal = fields.vec3("normal")) {
    if (normal->x != 0 || normal->y != 0 || normal->z != 0)
      floor.normal = unit(*normal);
    else
      reading.out.error(fields.place_of("normal"), "normal: must not be zero");
  }
  floor.point = fields.number("height").value_or(0) * floor.normal;
  read_law(fields, rule.law, reading);
  if (const Value* belt = fields.find("belt")) floor.solid.belt = read_belt(*belt, reading.out);
  fields.finish();
  if (errors != reading.out.errors()) return;
  model.add_collider(floor);
  reading.floor_rule = std::move(rule);
}

void read_contact(const Value& table, Reading& reading) {
  Diagnostics& out = reading.out;
  const std::size_t errors = out.errors();
  Fields fields(table, contact_table, out);
  ContactRule rule;
  if (const auto name = fields.string("name"); name && check_bare_name(*name, fields.place_of("name"), "a contact", out))
    rule.name = *name;
  if (const Value* between = fields.find("between")) {
    const Value::Array* const names = between->array();
    if (names == nullptr || names->size() != 2)
      out.error(between->place, "between: expected two names", "for example between = [\"chain/*\", \"floor\"]");
    else
      rule.one = bodies_of(names->front(), reading, rule.one_name),
      rule.other = bodies_of(names->back(), reading, rule.other_name);
  }
  read_law(fields, rule.law, reading);
  rule.law.off = fields.boolean("off").value_or(false);
  fields.finish();
  if (errors == out.errors()) reading.scenario.model.add_contact_rule(std::move(rule));
}

void check_solid_uses(const Model& model, const std::vector<Reading::SolidUse>& uses, Diagnostics& out) {
  for (const Reading::SolidUse& use : uses) {
    const std::vector<std::string> names = use.what->solids();
    if (std::any_of(names.begin(), names.end(), [&](const auto& name) { return ContactBodies(model, name).empty(); }))
      continue;  // reported already
    if (std::optional<Error> error = cannot_touch(model, *use.what)) out.error(use.place, error->problem, error->hint);
  }
}

void check_contacts(Reading& reading) {
  const Scenario& scenario = reading.scenario;
  check_solid_uses(scenario.model, reading.solid_uses, reading.out);
  if (!scenario.model.has_contact()) return;
  if (const std::optional<Error> error = unfit_for_contact(scenario.model, scenario.integration.method))
    return reading.out.error({1, 1, 0}, error->problem, error->hint);
  if (!scenario.state_files.empty()) return;  // which say where bodies are
  const std::optional<Overlap> worst = overlap_between_models(reading);
  if (!worst) return;
  const auto place_of = [&](const std::string& body) {
    const auto place = reading.bodies.find(body);
    return place != reading.bodies.end() ? place->second : Place{};
  };
  const std::string by = text_of_length(worst->depth);
  if (!scenario.integration.resolve && !worst->cable.empty())
    return reading.out.error(reading.springs.at(worst->cable),
                             "length: the ends of cable " + in_quotes(worst->cable) + " are farther apart at the start, by " + by,
                             "give it a longer length, or leave it out: it is then as long as they are apart; or let resolve = "
                             "true in [integrate] bring "
                             "its ends together");
  if (!scenario.integration.resolve)
    return reading.out.error(place_of(worst->one),
                             in_quotes(worst->one) + " and " + in_quotes(worst->other) + " overlap by " + by + " at the start",
                             "move one of them, let them pass through each other by a [[contact]] with off = true, or push them "
                             "apart by resolve = true in [integrate]");
  const Separation separation = separation_of(scenario.model);
  if (const std::optional<Error> error = separation.error())
    return reading.out.error(place_of(separation.left->one), error->problem, error->hint);
  reading.out.warning(place_of(separation.body),
                      "bodies that overlap are pushed apart at the start, farthest " + in_quotes(separation.body) + ", by " +
                          text_of_length(separation.largest),
                      "");
}

}  // namespace momentree::io
