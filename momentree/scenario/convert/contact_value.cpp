// What bodies touch with, the floor and the laws of contacts, as parts of a scenario.
#include <algorithm>
#include <optional>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/base/wildcard.hpp>
#include <momentree/contact/shapes/height_field.hpp>
#include <momentree/model/contact_rules.hpp>
#include <momentree/scenario/convert/describe.hpp>
#include <momentree/scenario/read/collider_shapes.hpp>

namespace momentree::io {

using namespace document_values;

namespace {

Shape shape_of(const contact::Solid& solid, const std::string& body) {
  Shape shape = solid_shape(solid);
  if (shape.kind == Shape::Kind::none)
    throw_error({"the collision of '" + body + "' is a mesh, which a scenario names by its file", "",
                 "write a scenario with collision = { mesh = … }, or use boxes, spheres, capsules, cylinders and ellipsoids"});
  return shape;
}

Value::Table belt_entries_of(const Vec3& belt) {
  Value::Table table;
  if (belt != Vec3{}) add(table, "axis", list(belt)), add(table, "speed", number(norm(belt)));
  return table;
}

Value describe_field(const contact::HeightField& field) {
  Value::Array rows;
  for (int j = field.rows - 1; j >= 0; --j) {
    Value::Array row;
    for (int i = 0; i < field.columns; ++i) row.push_back(number(field.heights[static_cast<std::size_t>(j * field.columns + i)]));
    rows.push_back(value(std::move(row)));
  }
  Value::Table table;
  add(table, "heightmap", value(std::move(rows))), add(table, "size", list(Vec3{field.x, field.y, 1}));
  if (Value::Table at = placement(field.at); !at.empty()) add(table, "at", value(std::move(at)));
  return value(std::move(table));
}

Value describe_friction(const ContactLaw& law) {
  if (law.static_friction == law.friction && !law.has_moments()) return number(law.friction);
  Value::Table table;
  if (law.static_friction != law.friction) add(table, "static", number(law.static_friction));
  add(table, "kinetic", number(law.friction));
  if (law.torsional > 0) add(table, "torsional", number(law.torsional));
  if (law.rolling > 0) add(table, "rolling", number(law.rolling));
  return value(std::move(table));
}

// How `between` names the bodies of a rule; empty if no single name stands for them.
std::string name_of(const std::vector<BodyId>& set, const std::string& written, const Model& model) {
  if (set.size() == 1 && set.front() == ground) return "ground";
  if (set.empty() || std::any_of(set.begin(), set.end(), [](BodyId body) { return body.index < 0; })) return {};
  if (!written.empty() && std::all_of(set.begin(), set.end(), [&](BodyId body) { return names_body(written, model[body].name); }))
    return written;
  return set.size() == 1 ? model[set.front()].name : std::string();
}

std::vector<BodyId> bodies_that_touch(const Model& model) {
  std::vector<BodyId> bodies;
  for (const Collider& collider : model.colliders())
    if (bodies.empty() || std::find(bodies.begin(), bodies.end(), collider.body) == bodies.end()) bodies.push_back(collider.body);
  return bodies;
}

// Names that are empty: all bodies.
Value describe_rule(const ContactRule& rule, const std::string& one, const std::string& other) {
  Value::Table table;
  if (!rule.name.empty()) add(table, "name", text(rule.name));
  if (!one.empty()) add(table, "between", value(Value::Array{text(one), text(other)}));
  add(table, "friction", describe_friction(rule.law));
  if (rule.law.restitution != 0) add(table, "restitution", number(rule.law.restitution));
  if (rule.law.off) add(table, "off", Value(true, Place{}));
  return value(std::move(table));
}

// The number of the plane that is the floor of a scenario; −1 without one.
int floor_of(const Model& model) {
  const std::vector<Collider>& all = model.colliders();
  const auto plane = std::find_if(all.begin(), all.end(), [](const Collider& c) { return c.plane; });
  return plane == all.end() ? -1 : static_cast<int>(plane - all.begin());
}

// The rule that friction and restitution of a floor are read as, before all others.
bool begins_with_rule_of_floor(const Model& model) {
  if (model.contact_rules().empty()) return false;
  const ContactRule& rule = model.contact_rules().front();
  return floor_of(model) >= 0 && rule.one.empty() && rule.other == std::vector<BodyId>{ground} && rule.name.empty() &&
         !rule.law.off;
}

// True if a body and its parent do not touch, but would if a rule named both.
bool joint_keeps_apart(const Model& model, BodyId one, BodyId other) {
  if (one == ground || other == ground || (model[one].parent != other && model[other].parent != one)) return false;
  return !model.contact_law(one, other).off && !touch_while_joined(model, one, other);
}

// The pairs to which a rule applies unless a later one does.
void add_pairs(const Model& model, const std::vector<BodyId>& bodies, const ContactRule& rule, Value::Array& out) {
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (std::size_t k = i + 1; k < bodies.size(); ++k)
      if (applies(rule, bodies[i], bodies[k]) && !joint_keeps_apart(model, bodies[i], bodies[k]))
        out.push_back(describe_rule(rule, model.body_name(bodies[i]), model.body_name(bodies[k])));
}

}  // namespace

Value describe_collision(const Model& model, BodyId body, const std::vector<Shape>& collision_shapes) {
  Value::Array all;
  LeftOut none;
  for (std::size_t i = 0; i < model.colliders().size(); ++i) {
    const Collider& collider = model.colliders()[i];
    if (collider.body != body || static_cast<int>(i) == floor_of(model)) continue;
    if (collider.plane) {
      if (collider.solid.belt != Vec3{})
        throw_error({"only one plane of the ground has a belt in a scenario, its floor", "", "give a fixed body the belt"});
      all.push_back(describe_shape({.kind = Shape::Kind::plane, .size = collider.normal, .at = Pose(collider.point)}, {}, none));
      continue;
    }
    if (collider.field) {
      all.push_back(describe_field(*collider.field));
      continue;
    }
    if (i < collision_shapes.size() && collision_shapes[i].part) continue;
    const bool mesh = i < collision_shapes.size() && collision_shapes[i].kind == Shape::Kind::mesh;
    all.push_back(
        describe_shape(mesh ? collision_shapes[i] : shape_of(collider.solid, std::string(model.body_name(body))), {}, none));
  }
  return value(std::move(all));
}

Value::Table describe_belt(const Model& model, BodyId body) {
  std::optional<Vec3> belt;
  for (const Collider& collider : model.colliders()) {
    if (collider.body != body) continue;
    if (belt && *belt != collider.solid.belt)
      throw_error({"only some of the shapes with which '" + model[body].name + "' touches have a belt", "",
                   "weld a body with these shapes to it"});
    belt = collider.solid.belt;
  }
  return belt_entries_of(belt.value_or(Vec3{}));
}

Value::Table describe_floor(const Model& model) {
  Value::Table table;
  if (floor_of(model) < 0) return table;
  const Collider& collider = model.colliders()[static_cast<std::size_t>(floor_of(model))];
  add(table, "height", number(dot(collider.normal, collider.point)));
  add(table, "normal", list(collider.normal));
  if (Value::Table belt = belt_entries_of(collider.solid.belt); !belt.empty()) add(table, "belt", value(std::move(belt)));
  if (!begins_with_rule_of_floor(model)) return table;
  const ContactLaw& law = model.contact_rules().front().law;
  add(table, "friction", describe_friction(law));
  if (law.restitution != 0) add(table, "restitution", number(law.restitution));
  return table;
}

Value describe_contacts(const Model& model) {
  const std::vector<BodyId> bodies = bodies_that_touch(model);
  Value::Array by_rules;
  bool whole = true, of_floor = begins_with_rule_of_floor(model);
  for (const ContactRule& rule : model.contact_rules()) {
    if (std::exchange(of_floor, false)) continue;  // it is in the floor's table
    const std::string one = name_of(rule.one, rule.one_name, model), other = name_of(rule.other, rule.other_name, model);
    if (!one.empty() && !other.empty())
      by_rules.push_back(describe_rule(rule, one, other));
    else if (rule.one.empty() && rule.other.empty())
      by_rules.push_back(describe_rule(rule, "", ""));
    else if ((rule.one.empty() && other == "ground") || (rule.other.empty() && one == "ground"))
      by_rules.push_back(describe_rule(rule, "*", "ground"));
    else
      whole = false, add_pairs(model, bodies, rule, by_rules);
  }
  if (whole) return value(std::move(by_rules));
  // Rules for many bodies by number: pair by pair, either of each rule, or with the rule that applies in the end.
  Value::Array by_pairs;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (std::size_t k = i + 1; k < bodies.size(); ++k)
      if (const ContactRule* const rule = model.contact_rule(bodies[i], bodies[k]);
          rule != nullptr && !joint_keeps_apart(model, bodies[i], bodies[k]))
        by_pairs.push_back(describe_rule(*rule, model.body_name(bodies[i]), model.body_name(bodies[k])));
  return value(by_rules.size() <= by_pairs.size() ? std::move(by_rules) : std::move(by_pairs));
}

}  // namespace momentree::io
