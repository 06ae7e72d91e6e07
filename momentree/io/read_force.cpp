// [[force]]: external forces on bodies.
#include <momentree/io/freedom_values.hpp>
#include <momentree/io/read_action.hpp>

namespace momentree::io {

namespace {

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
  Fields fields(value, "drag", out);
  if (!value.table()) return;
  drag.linear = fields.not_negative("linear", dimension::force / dimension::speed).value_or(0);
  // With an area, the coefficient is half of density times drag coefficient.
  const Dimension whole = dimension::force / (dimension::speed * dimension::speed), area = dimension::length * dimension::length;
  drag.quadratic = fields.not_negative("quadratic", fields.has("area") ? whole / area : whole).value_or(0);
  drag.area = fields.not_negative("area", area).value_or(1);
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

void read_force(const Value& table, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, "[[force]]", out);
  const Value* body = fields.require("body", "the body on which it acts, or \"chain/*\" for each");
  const std::vector<std::string> bodies = body ? bodies_named(*body, reading) : std::vector<std::string>{};
  BodyForce force;
  force.point = fields.vec3("point", dimension::length).value_or(Vec3{});
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
