#include <algorithm>
#include <cmath>
#include <cstdio>

#include <momentree/models/mesh/source.hpp>
#include <momentree/models/urdf/parts.hpp>

namespace momentree::io::urdf {

std::string usable_name(std::string name) {
  if (name == "ground") return "ground_";
  for (const char c : {'/', ',', '"', '*'}) std::replace(name.begin(), name.end(), c, '_');
  return name;
}

std::string read_name(XmlFields& fields, std::string_view what, XmlFile& file) {
  const std::string given = fields.string("name").value_or("");
  const XmlLocation location = fields.location("name");
  std::string name = usable_name(given);
  if (!check_name(name, location, what, file) || name == given) return name;
  if (given == "ground")
    file.once(Severity::warning, "'ground' means the ground here: it is renamed 'ground_'", "", location);
  else
    file.once(Severity::warning, "a name with / , \" or * cannot be part of a path: they become _ here",
              "use the new name in scenarios", location);
  return name;
}

Pose read_origin(XmlFields& fields, XmlFile& file) {
  const XmlElement origin = fields.child("origin");
  if (!origin) return {};
  XmlFields of(origin, file);
  Pose pose;
  pose.position = of.vec3("xyz").value_or(Vec3{});
  const Vec3 rpy = of.vec3("rpy").value_or(Vec3{});
  pose.rotation = from_rpy(rpy.x, rpy.y, rpy.z);
  if (const auto q = of.numbers("quat_xyzw", 4)) {
    const Quat given{(*q)[3], (*q)[0], (*q)[1], (*q)[2]};
    const double length = std::hypot(std::hypot(given.w, given.x), std::hypot(given.y, given.z));
    if (std::fabs(length - 1) > 1e-3)
      file.error(of.location("quat_xyzw"), "quat_xyzw: the length of the quaternion is not 1");
    else
      pose.rotation = normalized(given);
    if (of.has("rpy")) file.error(of.location("rpy"), "rpy and quat_xyzw give the rotation twice", "leave one of them out");
  }
  of.finish();
  return pose;
}

std::string read_material(XmlElement material, XmlFile& file) {
  XmlFields fields(material, file);
  fields.known({"name"});
  fields.known_children({"texture"});
  std::string colour;
  if (const XmlElement color = fields.child("color")) {
    XmlFields of(color, file);
    of.require("rgba", "for example rgba=\"0.8 0.2 0.1 1\"");
    if (const auto rgba = of.numbers("rgba", 4)) colour = colour_text(*rgba);
    of.finish();
  }
  fields.finish();
  return colour;
}

namespace {

void read_inertia(XmlElement inertia, BodySpec& spec, const Quat& axes, XmlFile& file) {
  XmlFields fields(inertia, file);
  for (const char* moment : {"ixx", "iyy", "izz"}) fields.require(moment, "about the centre of mass, in the axes of <origin>");
  Sym3 m{};
  m.xx = fields.number("ixx").value_or(0);
  m.yy = fields.number("iyy").value_or(0);
  m.zz = fields.number("izz").value_or(0);
  m.xy = fields.number("ixy").value_or(0);
  m.xz = fields.number("ixz").value_or(0);
  m.yz = fields.number("iyz").value_or(0);
  fields.finish();
  const bool turned = axes.x != 0 || axes.y != 0 || axes.z != 0;
  spec.inertia = turned ? rotate(rotation_matrix(axes), m) : m;
}

// Zeros that a program computed: a radius of gyration below 30 nm.
bool only_round_off(const Sym3& inertia, double mass) {
  const auto& [xx, yy, zz, xy, xz, yz] = inertia;
  double largest = 0;
  for (const double each : {xx, yy, zz, xy, xz, yz}) largest = std::max(largest, std::fabs(each));
  return largest > 0 && largest < 1e-15 * mass;
}

void read_inertial(XmlElement inertial, BodySpec& spec, XmlFile& file) {
  XmlFields fields(inertial, file);
  const std::size_t errors = file.out().errors();
  const Pose origin = read_origin(fields, file);
  spec.com = origin.position;
  if (const XmlElement mass = fields.require_child("mass", "for example <mass value=\"1.5\"/>, in kg")) {
    XmlFields of(mass, file);
    of.require("value", "the mass in kg");
    spec.mass = of.not_negative("value").value_or(0);
    of.finish();
  }
  if (const XmlElement inertia = fields.child("inertia")) {
    read_inertia(inertia, spec, origin.rotation, file);
    if (only_round_off(spec.inertia, spec.mass) && !check_mass(spec.mass, spec.inertia).what.empty()) {
      file.once(Severity::warning, "an inertia that no body has, of the size of round-off, counts as zero",
                "all the mass is at one point: is the inertia missing?", {inertia});
      spec.inertia = {};
    }
  } else if (spec.mass > 0) {
    file.warning({inertial}, "<inertial> has no <inertia>: all the mass is at one point", "give ixx, iyy and izz");
  }
  fields.finish();
  // reported already: use values that cause no further messages
  if (errors != file.out().errors()) spec.mass = 1, spec.inertia = diagonal(1);
}

void read_geometry(XmlElement geometry, Shape& shape, Import& import, XmlFile& file) {
  XmlFields fields(geometry, file);
  if (const XmlElement box = fields.child("box")) {
    XmlFields of(box, file);
    of.require("size", "its three edges");
    const Vec3 size = of.vec3("size").value_or(Vec3{1, 1, 1});
    if (size.x < 0 || size.y < 0 || size.z < 0) file.error(of.location("size"), "size: must not be negative");
    shape.kind = Shape::Kind::primitive, shape.primitive = contact::Box{size};
    of.finish();
  }
  const auto read = [&](const char* tag, const auto& sizes_of) {
    const XmlElement element = fields.child(tag);
    if (!element) return;
    XmlFields of(element, file);
    const auto size = [&of](const char* key) {
      of.require(key);
      return of.not_negative(key).value_or(1);
    };
    shape.kind = Shape::Kind::primitive, shape.primitive = sizes_of(size);
    of.finish();
  };
  read("sphere", [](const auto& size) { return contact::Sphere{size("radius")}; });
  read("cylinder", [](const auto& size) { return contact::Cylinder{size("radius"), size("length")}; });
  read("capsule", [](const auto& size) -> contact::Primitive {
    const contact::Capsule capsule{size("radius"), size("length")};
    if (!(capsule.length > 0)) return contact::Sphere{capsule.radius};
    return capsule;
  });
  if (const XmlElement mesh = fields.child("mesh")) {
    XmlFields of(mesh, file);
    of.require("filename");
    const auto name = of.string("filename");
    if (const auto scale = of.numbers("scale", 1, 3)) {
      const std::vector<double>& s = *scale;
      shape.scale = s.size() == 3 ? Vec3{s[0], s[1], s[2]} : Vec3{s[0], s[0], s[0]};
    }
    if (name) import.read_mesh(*name, of.location("filename"), shape, file);
    of.finish();
  }
  fields.finish();
}

void read_visual(XmlElement visual, const Materials& materials, ImportedBody& body, Import& import, XmlFile& file) {
  XmlFields fields(visual, file);
  fields.known({"name"});
  Shape shape;
  shape.at = read_origin(fields, file);
  if (const XmlElement geometry = fields.require_child("geometry")) read_geometry(geometry, shape, import, file);
  if (const XmlElement material = fields.child("material")) {
    shape.colour = read_material(material, file);
    if (const auto name = material.find("name"); name && shape.colour.empty()) {
      const auto known = materials.find(std::string(material.attribute(*name)));
      if (known != materials.end()) shape.colour = known->second;
    }
  }
  fields.finish();
  if (shape.source && !shape.colour.empty()) {  // colours in the mesh itself take precedence, as in RViz
    auto source = std::make_shared<MeshSource>(*shape.source);
    source->colour = shape.colour;
    shape.source = std::move(source);
  }
  if (shape.kind != Shape::Kind::none) body.shapes.push_back(std::move(shape));
}

void read_collision(XmlElement collision, ImportedBody& body, Import& import, XmlFile& file) {
  XmlFields fields(collision, file);
  fields.known({"name"});
  fields.known_children({"verbose", "contact_coefficients"});
  Shape shape;
  shape.at = read_origin(fields, file);
  if (const XmlElement geometry = fields.child("geometry")) read_geometry(geometry, shape, import, file);
  fields.finish();
  if (shape.kind != Shape::Kind::none) body.collision.push_back(std::move(shape));
}

}  // namespace

ImportedBody read_link(XmlElement link, const Materials& materials, Import& import) {
  XmlFile& file = import.file();
  XmlFields fields(link, file);
  ImportedBody body;
  body.spots = {&file, link};
  fields.known({"type"});
  if (fields.require("name", "for example name=\"upper_arm\"")) body.spec.name = read_name(fields, "a link", file);
  if (const XmlElement inertial = fields.child("inertial")) {
    body.spots.inertia = inertial;
    read_inertial(inertial, body.spec, file);
  }
  for (const XmlElement visual : fields.children("visual")) read_visual(visual, materials, body, import, file);
  for (const XmlElement collision : fields.children("collision")) read_collision(collision, body, import, file);
  fields.leave_out({"self_collision_checking", "collision_checking", "contact"}, "[[contact]] says what touches what");
  fields.finish();
  return body;
}

}  // namespace momentree::io::urdf
