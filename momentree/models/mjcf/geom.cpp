// Geoms: their masses and shapes.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include <momentree/base/error.hpp>
#include <momentree/models/mjcf/parts.hpp>

namespace momentree::io::mjcf {

namespace {

enum class Type { sphere, capsule, ellipsoid, cylinder, box, mesh, plane, hfield, sdf };
constexpr const char* type_names[] = {"sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "plane", "hfield", "sdf"};
constexpr std::size_t sizes_of[] = {1, 2, 3, 2, 3, 0, 0, 0, 0};

Type read_type(Attributes& attributes) {
  const std::string name = attributes.string("type").value_or("sphere");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::size(type_names); ++i) {
    if (name == type_names[i]) return static_cast<Type>(i);
    names.emplace_back(type_names[i]);
  }
  attributes.error("type", "unknown type of geom " + in_quotes(name), did_you_mean(name, names));
  return Type::plane;  // no further messages about it
}

struct Placed {
  Vec3 size{1, 1, 1};
  Pose pose{};
};

// Pose and size of the geom; between two points if `fromto` is given.
Placed read_placement(Attributes& attributes, Type type) {
  Placed placed;
  const auto index = static_cast<std::size_t>(type);
  const auto ends = attributes.numbers("fromto", 6);
  const bool between = attributes.has("fromto");
  const std::size_t needed = between ? 1 : sizes_of[index];
  if (needed > 0 && !attributes.has("size"))
    attributes.error("size", std::string("a ") + type_names[index] + " has no 'size'",
                     "half of its extent along each axis, or a radius");
  if (const auto size = attributes.numbers("size", std::max<std::size_t>(needed, 1), 3)) {
    const std::vector<double>& s = *size;
    for (std::size_t i = 0; i < needed; ++i)
      if (!(s[i] > 0)) {
        attributes.error("size", "size: must be greater than 0");
        return placed;
      }
    placed.size = {s[0], s.size() > 1 ? s[1] : s[0], s.size() > 2 ? s[2] : s.size() > 1 ? s[1] : s[0]};
  }
  if (!between) {
    placed.pose = attributes.pose();
    return placed;
  }
  if (type == Type::sphere || sizes_of[index] == 0) {
    attributes.error("fromto", std::string("fromto: a ") + type_names[index] + " does not have two ends", "");
    return placed;
  }
  if (!ends) return placed;
  const Vec3 from{(*ends)[0], (*ends)[1], (*ends)[2]}, to{(*ends)[3], (*ends)[4], (*ends)[5]}, along = from - to;
  const double length = norm(along);
  if (length < 1e-9) {
    attributes.error("fromto", "fromto: the two ends coincide");
    return placed;
  }
  const Vec3 z = (1 / length) * along;
  placed.pose.position = 0.5 * (from + to);
  placed.pose.rotation = z.z < -1 + 1e-12 ? Quat{0, 1, 0, 0} : normalized(Quat{1 + z.z, -z.y, z.x, 0});
  if (type == Type::capsule || type == Type::cylinder)
    placed.size = {placed.size.x, length / 2, 0};
  else
    placed.size = {placed.size.x, placed.size.x, length / 2};
  return placed;
}

// None for what is no primitive.
Shape shape_of(Type type, const Placed& placed) {
  const Vec3& s = placed.size;
  switch (type) {
    case Type::sphere: return Shape::of(contact::Sphere{s.x}, placed.pose);
    case Type::capsule: return Shape::of(contact::Capsule{s.x, 2 * s.y}, placed.pose);
    case Type::cylinder: return Shape::of(contact::Cylinder{s.x, 2 * s.y}, placed.pose);
    case Type::box: return Shape::of(contact::Box{2 * s}, placed.pose);
    case Type::ellipsoid: return Shape::of(contact::Ellipsoid{s}, placed.pose);
    default: return {.at = placed.pose};
  }
}

// A mask of 32 bits.
std::uint32_t read_bits(Attributes& attributes, const char* name) {
  const double given = attributes.number(name).value_or(1);
  if (given == std::floor(given) && std::fabs(given) < 4294967296.0)
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(given));
  attributes.error(name, std::string(name) + ": must be an integer of 32 bits");
  return 1;
}

}  // namespace

Geom read_geom(XmlElement element, const std::string& childclass, Reading& reading) {
  check_attributes(element, {"type",    "size",        "pos",     "quat",     "axisangle",  "xyaxes",    "zaxis",       "euler",
                             "fromto",  "mass",        "density", "group",    "rgba",       "material",  "mesh",        "hfield",
                             "contype", "conaffinity", "condim",  "friction", "priority",   "solref",    "solimp",      "solmix",
                             "margin",  "gap",         "user",    "fitscale", "fluidshape", "fluidcoef", "shellinertia"},
                   reading);
  Attributes attributes(element, childclass, reading);
  Geom geom;
  const Type type = read_type(attributes);
  geom.mask = {read_bits(attributes, "contype"), read_bits(attributes, "conaffinity")};
  if (const auto friction = attributes.numbers("friction", 1, 3)) geom.friction = friction->front();
  if (attributes.number("condim").value_or(3) > 3)
    reading.file_of(element).once(Severity::warning, "torsional and rolling friction of geoms are left out", moments_hint,
                                  attributes.at("condim"));
  if (type == Type::sdf)
    reading.file_of(element).once(Severity::warning,
                                  std::string("geoms of type ") + type_names[static_cast<std::size_t>(type)] +
                                      " are not supported: they are not drawn, and touch nothing",
                                  "use a mesh, or shapes", {element});
  if (type == Type::plane) geom.shape = {.kind = Shape::Kind::plane, .size = z_axis, .at = attributes.pose()};
  if (type == Type::hfield) {
    const std::string name = attributes.string("hfield").value_or("");
    const auto found = reading.fields.find(name);
    if (found == reading.fields.end())
      attributes.error("hfield", "there is no <hfield> " + in_quotes(name) + " in <asset>");
    else
      geom.shape = found->second, geom.shape.at = attributes.pose();
  }
  if (type == Type::plane || type == Type::hfield) return geom;  // without mass
  const Placed placed = read_placement(attributes, type);
  geom.shape = shape_of(type, placed);
  if (type == Type::mesh) geom.shape = mesh_shape(attributes.string("mesh").value_or(""), placed.pose, reading);
  if (const auto rgba = attributes.numbers("rgba", 4))
    geom.shape.colour = colour_text(*rgba);
  else if (const auto material = attributes.string("material"); material && reading.colours.contains(*material))
    geom.shape.colour = reading.colours.at(*material);

  const auto mass = attributes.not_negative("mass"), density = attributes.not_negative("density");
  const double group = attributes.number("group").value_or(0);
  geom.hidden = group >= 3;
  if (attributes.string("shellinertia") == "true")
    attributes.error("shellinertia", "inertias of shells are not supported", "give the body an <inertial>");
  if (group < reading.compiler.first_group || group > reading.compiler.last_group) return geom;
  if (type == Type::mesh || type == Type::sdf) {
    if (mass.value_or(density.value_or(1000)) > 0) geom.mesh_mass = {mass, density.value_or(1000)};
    return geom;
  }
  const contact::UniformBody solid = contact::uniform(geom.shape.primitive);
  if (!(solid.volume > 0)) return geom;  // reported
  const double scale = mass ? *mass / solid.volume : density.value_or(1000);
  geom.mass = mass_properties(geom.shape.primitive, placed.pose, scale);
  return geom;
}

}  // namespace momentree::io::mjcf
