#include <algorithm>

#include <momentree/base/characters.hpp>
#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr Key body_entries[] = {
    {"name", string, "Name within the mechanism", nullptr, "for example name = \"arm\""},
    {"mass", number(dimension::mass), "Mass; required without a density"},
    {"com", vector(dimension::length), "Centre of mass in the body's axes", "[0, 0, 0]"},
    {"inertia", moments,
     "Moments of inertia about the centre of mass, in kg m^2 or strings with units: one number for all three axes, "
     "3 principal values, or xx, yy, zz, xy, xz, yz",
     "0"},
    {"density", number(dimension::mass / (dimension::length * dimension::length * dimension::length), Range::positive),
     "In place of mass, com and inertia, which are then those of its shapes, or else of its collision: of one material, added "
     "up"},
    {"joint", table(joint_table), ""},
    {"shape", one_or_several(shape_table), "Shape for pictures: one, or a list of several"},
    {"collision",
     other(R"({"anyOf": [{"enum": ["shape", "none"]}, @, {"type": "array", "items": @, "minItems": 1}]})", shape_table),
     "What it touches other bodies with: shapes, \"shape\" (those drawn) or \"none\"", R"("none")"},
    {"belt", table(belt_table), "The surface of its collision runs"},
};

// Mass, centre of mass and inertia of the shapes of a body, or else of what it touches with.
void take_density(double density, const Fields& fields, BodyEntry& body, Diagnostics& out) {
  const auto refuse = [&](const std::string& what, const std::string& hint) {
    out.error(fields.place_of("density"), "density: " + what, hint);
  };
  std::vector<MassProperties> parts;
  const auto add = [&](const Shape& shape) {
    if (shape.kind == Shape::Kind::none) return;
    if (const std::optional<MassProperties> mass = mass_of(shape, density, refuse)) parts.push_back(*mass);
  };
  const std::size_t errors = out.errors();
  add(body.shape);
  for (const Shape& shape : body.shape.more) add(shape);
  if (body.shape.kind == Shape::Kind::none)
    for (const Shape& shape : body.collision_shapes)
      if (!shape.part) add(shape);
  if (parts.empty() && errors == out.errors())
    refuse("the body has no shape that it could be of", "give it a shape, or mass and inertia");
  const MassProperties sum = sum_of(parts);
  if (sum.mass > 0) body.spec.mass = sum.mass, body.spec.com = sum.com, body.spec.inertia = sum.inertia;
}

}  // namespace

constinit const KeyTable body_table{"[[mechanism.body]]", "body", "A rigid body", body_entries};

bool Reading::note(std::unordered_map<std::string, Place>& names, const std::string& name, Place place, const char* what) {
  const auto [found, fresh] = names.emplace(name, place);
  if (!fresh)
    out.error(place, "duplicate " + std::string(what) + " " + in_quotes(name) + ": the name is already used by another on " +
                         out.name_of(found->second));
  return fresh;
}

std::string Reading::suggest(const std::string& name, const std::unordered_map<std::string, Place>& names) {
  suggestions_left -= static_cast<long>(names.size());
  if (suggestions_left < 0) return {};
  std::vector<std::string> known;
  known.reserve(names.size());
  for (const auto& [each, place] : names) known.push_back(each);
  std::sort(known.begin(), known.end());
  return did_you_mean(name, known);
}

BodyEntry read_body(const Value& table, const std::string& mechanism, Reading& reading) {
  Diagnostics& out = reading.out;
  BodyEntry body;
  body.table = &table;
  Fields fields(table, body_table, out);
  fields.require("name");
  const auto name = fields.string("name");
  body.name_place = fields.place_of("name");
  if (name && check_bare_name(*name, body.name_place, "a body", out)) body.bare_name = *name;

  const std::size_t errors = out.errors();
  BodySpec& spec = body.spec;
  const std::optional<double> density = fields.number("density");
  if (!density) fields.require("mass", "in kg, or a string such as \"10 g\"; or density = \"2700 kg/m^3\" and a shape");
  for (const char* key : {"mass", "com", "inertia"})
    if (density && fields.has(key))
      out.error(fields.place_of(key), std::string(key) + ": the density determines it", "leave out one of them");
  spec.mass = fields.number("mass").value_or(1);
  spec.com = fields.vec3("com").value_or(Vec3{});
  if (const Value* inertia = fields.find("inertia")) spec.inertia = read_inertia(*inertia, "inertia", out).value_or(Sym3{});
  if (errors != out.errors()) spec.mass = 1, spec.inertia = {};  // reported already: use values that cause no further messages

  if (const Value* joint = fields.find("joint"))
    read_joint(*joint, body, reading);
  else
    body.rooted = true;
  if (const Value* shape = fields.find("shape")) body.shape = read_shape(*shape, reading);
  if (const Value* collision = fields.find("collision")) read_collision(*collision, body, reading);
  if (density && errors == out.errors()) take_density(*density, fields, body, out);
  if (const Value* belt = fields.find("belt")) {
    const Vec3 runs = read_belt(*belt, out);
    for (contact::Solid& solid : body.collision) solid.belt = runs;
    if (body.collision.empty() && errors == out.errors())
      out.error(belt->place, "belt: the body has no collision", "give it one: it is the surface that runs");
  }
  fields.finish();

  if (body.bare_name.empty()) return body;
  spec.name = mechanism + "/" + body.bare_name;
  body.named = reading.note(reading.bodies, spec.name, body.name_place, "body");
  if (body.bare_joint.empty()) body.bare_joint = body.bare_name;
  spec.joint_name = mechanism + "/" + body.bare_joint;
  const Value::Entry* own = body.joint ? body.joint->find("name") : nullptr;
  // A duplicate body without its own joint name was reported already.
  if (body.named || own) {
    reading.note(reading.joints, spec.joint_name, own ? own->value.place : body.name_place, "joint");
    if (spec.joint_name != spec.name) reading.body_of_joint.emplace(spec.joint_name, spec.name);
  }
  return body;
}

}  // namespace momentree::io
