#include <algorithm>
#include <cmath>
#include <cstdio>

#include <momentree/models/mesh/split.hpp>
#include <momentree/models/sdf/parts.hpp>

namespace momentree::io::sdf {

namespace {

void read_inertia(XmlElement inertia, const Quat& axes, LinkPart& link, XmlFile& file) {
  Texts texts(inertia, file);
  Sym3 m{};
  const auto moment = [&](const char* name) {
    if (const auto value = texts.number(name)) return *value;
    if (!texts.fields.child(name))
      file.once(Severity::warning, "<inertia> has no <" + std::string(name) + ">: the format's default is 1 kg m²", "",
                {inertia});
    return 1.0;
  };
  m.xx = moment("ixx"), m.yy = moment("iyy"), m.zz = moment("izz");
  m.xy = texts.number("ixy").value_or(0), m.xz = texts.number("ixz").value_or(0), m.yz = texts.number("iyz").value_or(0);
  texts.fields.finish();
  const bool turned = axes.x != 0 || axes.y != 0 || axes.z != 0;
  link.inertia = turned ? rotate(rotation_matrix(axes), m) : m;
}

void read_inertial(XmlElement inertial, Version version, LinkPart& link, XmlFile& file) {
  const std::size_t errors = file.out().errors();
  Texts texts(inertial, file);
  if (texts.fields.boolean("auto").value_or(false))
    file.error(texts.fields.location("auto"), "computing the inertia from collisions is not supported",
               "give mass and inertia as numbers");
  const FramedPose pose = read_pose(texts.fields, version, file);
  if (!pose.relative_to.empty())
    file.error(pose.location, "the pose of an <inertial> is relative to its link and cannot name a frame",
               "leave the attribute out");
  link.com = pose.pose.position;
  if (const auto mass = texts.not_negative("mass"))
    link.mass = *mass;
  else if (!texts.fields.child("mass"))
    file.once(Severity::warning, "<inertial> has no <mass>: the format's default is 1 kg", "", {inertial});
  if (const XmlElement inertia = texts.fields.child("inertia"))
    read_inertia(inertia, pose.pose.rotation, link, file);
  else
    file.once(Severity::warning, "<inertial> has no <inertia>: the format's default is 1 kg m² about every axis", "", {inertial});
  if (const XmlElement added = texts.fields.child("fluid_added_mass"))
    file.once(Severity::warning, "<fluid_added_mass> is ignored: fluids are not simulated", "", {added});
  texts.fields.leave_out({"density", "auto_inertia_params"}, "");
  texts.fields.finish();
  // reported already: use values that cause no further messages
  if (errors != file.out().errors()) link.mass = 1, link.inertia = diagonal(1);
}

double positive(Texts& texts, const char* name, XmlElement of, XmlFile& file) {
  const auto value = texts.number(name);
  if (!value && !texts.fields.child(name)) file.error({of}, of.tag() + " has no <" + std::string(name) + ">");
  if (!value || *value > 0) return value.value_or(1);
  file.error(texts.location(), std::string(name) + ": must be greater than 0");
  return 1;
}

// `drawn`: pictures show the planes that are touched, and no others.
void read_geometry(XmlElement geometry, bool drawn, Shape& shape, Import& import, XmlFile& file) {
  XmlFields fields(geometry, file);
  const auto read = [&](const char* tag, const auto& sizes_of) {
    const XmlElement element = fields.child(tag);
    if (!element) return;
    Texts texts(element, file);
    shape.kind = Shape::Kind::primitive, shape.primitive = sizes_of(texts);
    texts.fields.finish();
  };
  const auto three = [&](Texts& texts, const char* key) {
    const Vec3 size = texts.vec3(key).value_or(Vec3{1, 1, 1});
    if (size.x > 0 && size.y > 0 && size.z > 0) return size;
    file.error(texts.location(), std::string(key) + ": must be greater than 0");
    return Vec3{1, 1, 1};
  };
  const auto one = [&](Texts& texts, const char* key) { return positive(texts, key, texts.fields.element(), file); };
  read("box", [&](Texts& texts) { return contact::Box{three(texts, "size")}; });
  read("ellipsoid", [&](Texts& texts) { return contact::Ellipsoid{three(texts, "radii")}; });
  read("sphere", [&](Texts& texts) { return contact::Sphere{one(texts, "radius")}; });
  read("cylinder", [&](Texts& texts) { return contact::Cylinder{one(texts, "radius"), one(texts, "length")}; });
  read("capsule", [&](Texts& texts) { return contact::Capsule{one(texts, "radius"), one(texts, "length")}; });
  if (const XmlElement mesh = fields.child("mesh")) {
    Texts texts(mesh, file);
    const auto uri = texts.string("uri");
    const XmlLocation location = texts.location();
    shape.scale = texts.vec3("scale").value_or(Vec3{1, 1, 1});
    if (texts.fields.string("optimization") == "convex_decomposition" && !drawn) shape.split = usual_split;
    std::string submesh;
    if (const XmlElement part = texts.fields.child("submesh")) {
      Texts of(part, file);
      submesh = of.string("name").value_or("");
      if (of.boolean("center").value_or(false))
        file.once(Severity::note, "<center> is ignored: pictures show the submesh where it is in the mesh", "", {part});
      of.fields.finish();
    }
    if (drawn || shape.split == 0)
      texts.fields.known_children({"convex_decomposition"});
    else
      texts.fields.leave_out({"convex_decomposition"}, "split in the mechanism says how close convex parts are");
    texts.fields.finish();
    if (uri)
      import.read_mesh(*uri, location, shape, file, submesh);
    else
      file.error({mesh}, "<mesh> has no <uri>");
  }
  if (const XmlElement plane = drawn ? XmlElement{} : fields.child("plane")) {
    Texts texts(plane, file);
    shape.kind = Shape::Kind::plane;
    shape.size = texts.vec3("normal").value_or(z_axis);
    if (shape.size == Vec3{}) file.error(texts.location(), "normal: must not be zero"), shape.size = z_axis;
    texts.fields.known_children({"size"});  // of what is drawn: it has no edge
    texts.fields.finish();
  }
  if (const XmlElement heightmap = drawn ? XmlElement{} : fields.child("heightmap")) {
    Texts texts(heightmap, file);
    const auto uri = texts.string("uri");
    const XmlLocation location = texts.location();
    shape.size = texts.vec3("size").value_or(Vec3{1, 1, 1});
    if (!(shape.size.x > 0 && shape.size.y > 0 && shape.size.z > 0))
      file.error(texts.location(), "size: must be greater than 0"), shape.size = {1, 1, 1};
    shape.at = shape.at * Pose(texts.vec3("pos").value_or(Vec3{}));
    texts.fields.known_children({"texture", "blend", "use_terrain_paging", "sampling"});  // of what is drawn
    texts.fields.finish();
    if (!uri) file.error({heightmap}, "<heightmap> has no <uri>");
    if (uri) shape.heights = import.read_heights(*uri, location, file);
    if (shape.heights) shape.kind = Shape::Kind::heights;
  }
  fields.known_children({"empty"});
  fields.leave_out({"plane", "heightmap", "polyline", "image", "cone"}, "pictures do not show it, and it touches nothing");
  fields.finish();
}

std::string colour_of(Texts& material, XmlFile& file) {
  std::string colour;
  for (const char* name : {"ambient", "diffuse"}) {
    const XmlElement element = material.fields.child(name);
    if (!element || element.text().empty()) continue;
    const auto rgba = read_numbers(element.text(), 3, 4, {element, XmlLocation::no_attribute, true}, name, file);
    if (rgba) colour = colour_text(*rgba);
  }
  material.fields.known_children(
      {"specular", "emissive", "script", "shader", "lighting", "pbr", "render_order", "double_sided", "shininess"});
  material.fields.finish();
  return colour;
}

// A shape with its pose, which may name a frame.
void keep_shape(Shape shape, FramedPose pose, std::vector<Shape>& shapes,
                std::vector<std::pair<std::size_t, FramedPose>>& placed) {
  if (shape.kind == Shape::Kind::none) return;
  if (!pose.relative_to.empty()) placed.emplace_back(shapes.size(), std::move(pose));
  shapes.push_back(std::move(shape));
}

void read_visual(XmlElement visual, Version version, LinkPart& link, Import& import, XmlFile& file) {
  XmlFields fields(visual, file);
  fields.known({"name"});
  Shape shape;
  FramedPose pose = read_pose(fields, version, file);
  shape.at = pose.pose;
  if (const XmlElement geometry = fields.require_child("geometry")) read_geometry(geometry, true, shape, import, file);
  if (const XmlElement material = fields.child("material")) {
    Texts texts(material, file);
    shape.colour = colour_of(texts, file);
  }
  fields.known_children({"cast_shadows", "transparency", "laser_retro", "meta", "visibility_flags", "plugin"});
  fields.finish();
  keep_shape(std::move(shape), std::move(pose), link.shapes, link.placed_shapes);
}

// The coefficient of <surface>, or nothing.
std::optional<double> read_surface(XmlElement surface, XmlFile& file) {
  std::optional<double> friction;
  Texts texts(surface, file);
  if (const XmlElement element = texts.fields.child("friction")) {
    Texts of(element, file);
    if (const XmlElement ode = of.fields.child("ode")) {
      Texts coefficients(ode, file);
      friction = coefficients.not_negative("mu");
      const auto other = coefficients.not_negative("mu2");
      if (other && *other != friction.value_or(1))
        file.once(Severity::warning, different_friction, friction_hint, coefficients.location());
      coefficients.fields.known_children({"fdir1", "slip1", "slip2"});
      coefficients.fields.finish();
    }
    of.fields.leave_out({"torsional"}, moments_hint);
    of.fields.known_children({"bullet"});
    of.fields.finish();
  }
  texts.fields.leave_out({"bounce"}, "[[contact]] gives pairs their restitution");
  texts.fields.known_children({"contact", "soft_contact"});
  texts.fields.finish();
  return friction;
}

void read_collision(XmlElement collision, Version version, LinkPart& link, Import& import, XmlFile& file) {
  XmlFields fields(collision, file);
  fields.known({"name"});
  Shape shape;
  FramedPose pose = read_pose(fields, version, file);
  shape.at = pose.pose;
  if (const XmlElement geometry = fields.child("geometry")) read_geometry(geometry, false, shape, import, file);
  pose.pose = shape.at;
  if (const XmlElement surface = fields.child("surface"))
    if (const auto friction = read_surface(surface, file)) link.friction = std::max(link.friction, *friction);
  fields.known_children({"max_contacts", "laser_retro", "density", "auto_inertia_params"});
  fields.finish();
  keep_shape(std::move(shape), std::move(pose), link.collision, link.placed_collision);
}

// Warns of settings by which a link moves differently than by masses and joints.
void warn_of_special(Texts& texts, XmlFile& file) {
  if (!texts.boolean("gravity").value_or(true))
    file.once(Severity::warning, "<gravity> of a link is ignored: gravity acts on every body", "", texts.location());
  if (texts.boolean("kinematic").value_or(false))
    file.once(Severity::warning, "<kinematic> is ignored: the link moves dynamically", "", texts.location());
  if (const XmlElement decay = texts.fields.child("velocity_decay")) {
    Texts rates(decay, file);
    const double linear = rates.number("linear").value_or(0), angular = rates.number("angular").value_or(0);
    rates.fields.finish();
    if (linear != 0 || angular != 0)
      file.once(Severity::warning, "<velocity_decay> is ignored", "a scenario's [[force]] with a drag slows bodies down",
                {decay});
  }
}

}  // namespace

LinkPart read_link(XmlElement element, Version version, Import& import, XmlFile& file) {
  LinkPart link;
  link.element = element;
  Texts texts(element, file);
  XmlFields& fields = texts.fields;
  link.name = read_name(fields, "a link", version, file);
  link.pose = read_pose(fields, version, file);
  if (const XmlElement inertial = fields.child("inertial")) {
    link.inertial = inertial;
    read_inertial(inertial, version, link, file);
  } else {
    file.once(Severity::warning, "a link without <inertial>: the format's defaults are a mass of 1 kg and an inertia of 1 kg m²",
              "give a light link small numbers", {element});
  }
  for (const XmlElement visual : fields.children("visual")) read_visual(visual, version, link, import, file);
  warn_of_special(texts, file);
  fields.known_children({"self_collide", "enable_wind", "must_be_base_link"});
  for (const XmlElement collision : fields.children("collision")) read_collision(collision, version, link, import, file);
  fields.leave_out({"sensor", "projector", "audio_sink", "audio_source", "battery", "light", "particle_emitter", "plugin"},
                   "it belongs to another program");
  fields.finish();
  return link;
}

}  // namespace momentree::io::sdf
