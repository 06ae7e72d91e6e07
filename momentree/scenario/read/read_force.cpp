// [[force]]: external forces on bodies.
#include <momentree/scenario/keys/dof_values.hpp>
#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr Key drag_entries[] = {
    {"linear", number(dimension::force / dimension::speed, Range::not_negative), "Linear coefficient", "0"},
    {"quadratic", number("N s^2/m^2, with an area in kg/m^3", Range::not_negative),
     "Quadratic coefficient; with an area, half of density times drag coefficient", "0"},
    {"area", number(dimension::length* dimension::length, Range::not_negative), "Area", "1"},
};
constexpr KeyTable drag_table{"drag",
                              "",
                              "Resistance of still air at `point`: −(linear + quadratic·area·|v|)·v",
                              drag_entries,
                              {{KeyRule::How::some, "linear quadratic"}}};

constexpr Key force_entries[] = {
    {"body", string, "Full name of the body; with a *, one force on each body that matches", nullptr,
     "the body on which it acts, or \"chain/*\" for each"},
    {"point", vector(dimension::length), "Point where force and drag act, in the body's frame", "[0, 0, 0]"},
    {"force", signals(dimension::force), "Force: three components"},
    {"torque", signals(dimension::torque), "Torque: three components"},
    {"axes", choice("world|body"), "Axes of force and torque", R"("world")"},
    {"drag", table(drag_table), ""},
};

std::array<Signal, 3> read_components(Fields& fields, const char* key, const Dimension& expected, Diagnostics& out) {
  std::array<Signal, 3> all;
  const Value* value = fields.find(key);
  if (!value) return all;
  if (!value->array() || value->array()->size() != 3) {
    out.error(value->place,
              std::string(key) + ": expected three values, found " +
                  (value->array() ? "a list of " + std::to_string(value->array()->size()) : value->type_name()),
              "each of them a number, { table = … } or { sine = … }: [0, 0, { sine = { amplitude = 2, frequency = 1 } }]");
    return all;
  }
  for (std::size_t i = 0; i < 3; ++i) all[i] = read_signal((*value->array())[i], {expected}, key, out).value_or(Signal());
  return all;
}

void read_drag(const Value& value, Drag& drag, Diagnostics& out) {
  Fields fields(value, drag_table, out);
  if (!value.table()) return;
  drag.linear = fields.number("linear").value_or(0);
  // With an area, the coefficient is half of density times drag coefficient.
  const Dimension whole = dimension::force / (dimension::speed * dimension::speed), area = dimension::length * dimension::length;
  drag.quadratic = fields.number("quadratic", fields.has("area") ? whole / area : whole).value_or(0);
  drag.area = fields.number("area").value_or(1);
  if (fields.has("area") && !fields.has("quadratic"))
    out.error(fields.place_of("area"), "drag: 'area' goes with 'quadratic'", "the force is quadratic·area·v²");
  if (!fields.has("linear") && !fields.has("quadratic"))
    out.error(value.place, "drag: neither 'linear' nor 'quadratic'",
              "for example drag = { quadratic = \"0.6 kg/m^3\", area = \"0.5 m^2\" }");
  fields.finish();
}

std::vector<std::string> bodies_named(const Value& value, Reading& reading) {
  Diagnostics& out = reading.out;
  const auto name = read_string(value, "body", out);
  if (!name || reading.opaque.contains(mechanism_of(*name))) return {};
  if (name->find('*') != std::string::npos) {
    std::vector<std::string> found = matching_bodies(*name, reading);
    if (found.empty())
      out.error(value.place, "force: no body matches " + in_quotes(*name), "* matches within a name: \"chain/*\"");
    return found;
  }
  if (reading.bodies.contains(*name)) return {*name};
  std::string hint = *name == "ground" ? "the ground does not move" : reading.suggest(*name, reading.bodies);
  if (hint.empty() && name->find('/') == std::string::npos)
    for (const auto& [mechanism, where] : reading.mechanisms)
      if (reading.bodies.contains(mechanism + "/" + *name)) hint = "use the full name: " + in_quotes(mechanism + "/" + *name);
  out.error(value.place, "force: there is no body " + in_quotes(*name), std::move(hint));
  return {};
}

}  // namespace

constinit const KeyTable force_table{
    "[[force]]", "force", "An external force on a body", force_entries, {{KeyRule::How::some, "force torque drag"}}};

void read_force(const Value& table, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, force_table, out);
  const Value* body = fields.require("body");
  const std::vector<std::string> bodies = body ? bodies_named(*body, reading) : std::vector<std::string>{};
  BodyForce force;
  force.point = fields.vec3("point").value_or(Vec3{});
  force.force = read_components(fields, "force", dimension::force, out);
  force.torque = read_components(fields, "torque", dimension::torque, out);
  if (const auto axes = fields.string("axes")) {
    force.body_axes = *axes == "body";
    if (*axes != "body" && *axes != "world")
      out.error(fields.place_of("axes"), "axes: there is no " + in_quotes(*axes), "\"world\" (the default) or \"body\"");
  }
  if (const Value* drag = fields.find("drag")) read_drag(*drag, force.drag, out);
  if (!fields.has("force") && !fields.has("torque") && !fields.has("drag"))
    out.error(fields.place(), "[[force]] does nothing", "give force, torque or drag: force = [\"10 N\", 0, 0]");
  fields.finish();
  Model& model = reading.scenario.model;
  for (const std::string& name : bodies) {
    if (!model.has_body(name)) continue;  // of a mechanism with errors
    force.body = model.body(name);
    if (check_force(force).empty()) model.add_force(force);
  }
}

}  // namespace momentree::io
