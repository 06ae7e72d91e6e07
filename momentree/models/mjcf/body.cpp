// Bodies with their joints. MJCF nests bodies; a body with several joints becomes a chain with massless carriers.
#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/models/import/solid_mesh.hpp>
#include <momentree/models/mjcf/parts.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io::mjcf {

namespace {

struct Joint {
  std::string name;
  JointSpec spec{};
  JointLimits limits{};
  Vec3 anchor{};
  double start = 0;  ///< for one DoF
  XmlElement element{};
};

Kind kind_of(Attributes& attributes) {
  const std::string name = attributes.string("type").value_or("hinge");
  if (name == "hinge") return Kind::revolute;
  if (name == "slide") return Kind::prismatic;
  if (name == "ball") return Kind::ball;
  if (name == "free") return Kind::free;
  attributes.error("type", "unknown type of joint " + in_quotes(name), did_you_mean(name, {"hinge", "slide", "ball", "free"}));
  return Kind::revolute;
}

void read_limits(Attributes& attributes, Kind kind, Joint& joint, const Compiler& compiler) {
  const std::string limited = attributes.string("limited").value_or("auto");
  const bool given = attributes.has("range");
  if (limited == "false" || (limited == "auto" && !(compiler.autolimits && given))) return;
  if (limited != "true" && limited != "auto")
    return attributes.error("limited", "limited: expected true, false or auto, found " + in_quotes(limited));
  const auto range = attributes.numbers("range", 2);
  if (!given) return attributes.error("limited", "limited: the joint has no 'range'", "give one, or limited=\"false\"");
  if (!range || (kind != Kind::revolute && kind != Kind::prismatic)) return;
  const bool turns = kind == Kind::revolute;
  const double lower = turns ? compiler.angle((*range)[0]) : (*range)[0],
               upper = turns ? compiler.angle((*range)[1]) : (*range)[1];
  if (!(lower < upper)) return attributes.error("range", "range: the first number is not less than the second", "swap them");
  joint.limits.lower = lower;
  joint.limits.upper = upper;
}

void read_parameters(Attributes& attributes, Kind kind, Joint& joint, const Compiler& compiler) {
  JointParameters& p = joint.spec.parameters;
  const bool turns = kind == Kind::revolute;
  const auto take = [&](const char* name, Values& target) {
    if (const auto value = attributes.not_negative(name); value && *value > 0) target = *value;
  };
  take("damping", p.damping);
  take("armature", p.armature);
  take("stiffness", p.stiffness);
  if (const auto friction = attributes.not_negative("frictionloss"); friction && *friction > 0)
    p.friction = {*friction, imported_friction_speed};
  const double rest = attributes.number("springref").value_or(0), start = attributes.number("ref").value_or(0);
  if (kind == Kind::revolute || kind == Kind::prismatic) {
    joint.start = turns ? compiler.angle(start) : start;
    if (!p.stiffness.empty()) p.rest = turns ? compiler.angle(rest) : rest;
  }
  if (const auto pair = attributes.numbers("springdamper", 2); pair && (*pair)[0] > 0 && (*pair)[1] > 0)
    attributes.error("springdamper", "springdamper is not supported: it depends on the whole model",
                     "give stiffness and damping themselves");
}

Joint read_joint(XmlElement element, const std::string& childclass, Reading& reading) {
  Joint joint;
  joint.element = element;
  XmlFile& file = reading.file_of(element);
  const bool free = element.name() == "freejoint";
  if (free)
    check_attributes(element, {"group", "align"}, reading);
  else
    check_attributes(element,
                     {"type",
                      "group",
                      "pos",
                      "axis",
                      "springdamper",
                      "limited",
                      "range",
                      "actuatorfrclimited",
                      "actuatorfrcrange",
                      "solreflimit",
                      "solimplimit",
                      "solreffriction",
                      "solimpfriction",
                      "stiffness",
                      "margin",
                      "ref",
                      "springref",
                      "armature",
                      "damping",
                      "frictionloss",
                      "user"},
                     reading);
  if (const auto name = element.find("name")) {
    joint.name = element.attribute(*name);
    if (check_name(joint.name, {element, *name}, "a joint", file)) {
      const auto [first, fresh] = reading.joint_names.emplace(joint.name, element);
      if (!fresh)
        file.error({element, *name}, "duplicate joint " + in_quotes(joint.name) + ": the name is already used by another on " +
                                         reading.file_of(first->second).line_of(first->second));
    }
  }
  if (free) {
    joint.spec.kind = Kind::free;
    return joint;
  }
  Attributes attributes(element, childclass, reading);
  joint.spec.kind = kind_of(attributes);
  joint.anchor = attributes.vec3("pos").value_or(Vec3{});
  if (info(joint.spec.kind).axis) {
    joint.spec.axis = attributes.vec3("axis").value_or(Vec3{0, 0, 1});
    if (norm(joint.spec.axis) < 1e-9) {
      attributes.error("axis", "axis: an axis of length zero has no direction", "for example axis=\"0 0 1\"");
      joint.spec.axis = {0, 0, 1};
    }
  }
  read_parameters(attributes, joint.spec.kind, joint, reading.compiler);
  read_limits(attributes, joint.spec.kind, joint, reading.compiler);
  return joint;
}

// Eigenvalues of a symmetric matrix, ascending.
std::array<double, 3> eigenvalues(const Sym3& m) {
  const double mean = (m.xx + m.yy + m.zz) / 3, off = m.xy * m.xy + m.xz * m.xz + m.yz * m.yz;
  const double a = m.xx - mean, b = m.yy - mean, c = m.zz - mean, p = std::sqrt((a * a + b * b + c * c + 2 * off) / 6);
  if (p == 0) return {mean, mean, mean};
  const double det = a * (b * c - m.yz * m.yz) - m.xy * (m.xy * c - m.yz * m.xz) + m.xz * (m.xy * m.yz - b * m.xz);
  const double phi = std::acos(std::clamp(det / (2 * p * p * p), -1.0, 1.0)) / 3;
  const double most = mean + 2 * p * std::cos(phi), least = mean + 2 * p * std::cos(phi + 2.0943951023931953);
  return {least, 3 * mean - most - least, most};
}

MassProperties read_inertial(XmlElement inertial, Reading& reading) {
  XmlFile& file = reading.file_of(inertial);
  check_attributes(inertial, {"pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "mass", "diaginertia", "fullinertia"},
                   reading);
  Attributes attributes(inertial, "", reading);
  MassProperties mass;
  if (!attributes.has("mass")) file.error({inertial}, "<inertial> has no 'mass'", "in kg");
  if (!attributes.has("pos")) file.error({inertial}, "<inertial> has no 'pos'", "its centre of mass");
  const std::size_t errors = file.out().errors();
  mass.mass = attributes.not_negative("mass").value_or(1);
  const Pose pose = attributes.pose();
  mass.com = pose.position;
  Sym3 own{};
  if (const auto full = attributes.numbers("fullinertia", 6)) {
    const std::vector<double>& f = *full;
    own = {f[0], f[1], f[2], f[3], f[4], f[5]};
    if (attributes.has("diaginertia"))
      attributes.error("diaginertia", "diaginertia and fullinertia give the inertia twice", "leave one of them out");
  } else if (const auto diagonals = attributes.vec3("diaginertia")) {
    own = diagonal(diagonals->x, diagonals->y, diagonals->z);
  } else if (!attributes.has("fullinertia") && !attributes.has("diaginertia") && mass.mass > 0) {
    file.warning({inertial}, "<inertial> has no inertia: all the mass is at one point", "give diaginertia or fullinertia");
  }
  if (errors != file.out().errors()) return {1, {}, diagonal(1)};
  mass.inertia = rotate(rotation_matrix(pose.rotation), own);
  return mass;
}

// `paired`: a <pair> names it.
bool touches(const Geom& geom, bool paired) { return paired || geom.mask.own != 0 || geom.mask.others != 0; }

/// Reads the content of one <body>, before its children.
class BodyReader {
 public:
  BodyReader(XmlElement element, const std::string& childclass, const Pose& in_parent, Reading& reading)
      : element_(element), reading_(reading), file_(reading.file_of(element)), childclass_(childclass) {
    check_attributes(element,
                     {"childclass", "mocap", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "gravcomp", "user", "sleep"},
                     reading);
    if (const auto own = element.find("childclass")) {
      childclass_ = element.attribute(*own);
      if (!reading.classes.contains(childclass_))
        file_.error({element, *own}, "childclass: there is no default class " + in_quotes(childclass_));
    }
    Attributes attributes(element, "", reading);
    if (attributes.string("mocap") == "true")
      attributes.error("mocap", "bodies with a motion imposed from outside (mocap) are not supported", "leave it out");
    if (const auto compensation = attributes.number("gravcomp"); compensation && *compensation != 0)
      file_.once(Severity::warning, "gravcomp is ignored: gravity acts on every body", "", attributes.at("gravcomp"));
    pose_ = in_parent * attributes.pose();
    read_name();
    for (const XmlElement child : children_of(element, reading)) read(child);
  }

  const std::string& childclass() const { return childclass_; }
  const std::vector<XmlElement>& inner() const { return inner_; }

  /// Adds the body, and a carrier for each joint except the last; returns its index.
  int add(int parent) {
    const MassProperties mass = mass_of();
    ImportedBody body;
    body.spots = {&file_, element_, {}, inertial_ ? inertial_ : element_, {}};
    if (joints_.empty()) {
      body.spec.at = pose_;
      body.own_joint = parent >= 0;
    }
    for (const Joint& joint : joints_)
      if (joint.spec.kind == Kind::free && (parent >= 0 || joints_.size() > 1))
        file_.error({joint.element}, parent >= 0 ? "only a body in <worldbody> can have a free joint"
                                                 : "a free joint must be the only joint of its body");
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      ImportedBody one = body;
      place(joints_[j], j, one);
      one.spec.parent = {parent};
      if (j + 1 < joints_.size()) {
        parent = static_cast<int>(reading_.import.model.bodies.size());
        reading_.import.model.bodies.push_back(std::move(one));
      } else {
        body = std::move(one);
      }
    }
    body.spec.parent = {parent};
    body.spec.name = name_;
    if (body.spec.joint_name.empty()) body.spec.joint_name = name_;
    body.spec.mass = mass.mass;
    body.spec.com = mass.com;
    body.spec.inertia = mass.inertia;
    const auto drawn = [](const Shape& shape) { return shape.kind != Shape::Kind::mesh || shape.source; };
    body.collision = std::move(collision_), body.masks = std::move(masks_), body.friction = friction_;
    body.shapes = std::move(shapes_);
    if (std::none_of(body.shapes.begin(), body.shapes.end(), drawn))
      body.shapes.insert(body.shapes.end(), hidden_shapes_.begin(), hidden_shapes_.end());
    reading_.import.model.bodies.push_back(std::move(body));
    const int number = static_cast<int>(reading_.import.model.bodies.size()) - 1;
    for (const auto& [geom, friction] : paired_) reading_.geoms[geom] = {number, friction};
    for (const XmlElement site : sites_) read_site(site, childclass_, name_, number, reading_);
    return number;
  }

 private:
  void read_name() {
    const auto name = element_.find("name");
    if (!name) {
      do name_ = "body" + std::to_string(++reading_.unnamed);
      while (reading_.body_names.contains(name_));
      reading_.body_names.emplace(name_, element_);
      return;
    }
    name_ = element_.attribute(*name);
    if (!check_name(name_, {element_, *name}, "a body", file_)) return;
    const auto [first, fresh] = reading_.body_names.emplace(name_, element_);
    if (!fresh)
      file_.error({element_, *name}, "duplicate body " + in_quotes(name_) + ": the name is already used by another on " +
                                         reading_.file_of(first->second).line_of(first->second));
  }

  void read(XmlElement child) {
    const std::string_view name = child.name();
    if (name == "body") {
      inner_.push_back(child);
    } else if (name == "joint" || name == "freejoint") {
      if (joints_.size() >= 6) return file_.error({child}, "a body has more than 6 joints");
      joints_.push_back(read_joint(child, childclass_, reading_));
    } else if (name == "geom") {
      Geom geom = read_geom(child, childclass_, reading_);
      if (geom.mesh_mass) meshes_.push_back({child, geom.shape, *geom.mesh_mass});
      if (geom.mass.mass > 0) masses_.push_back(geom.mass);
      const auto geom_name = child.find("name");
      const bool paired = geom_name && reading_.geoms_of_pairs.contains(std::string(child.attribute(*geom_name)));
      if (paired) paired_.emplace_back(child.attribute(*geom_name), geom.friction);
      if (geom.shape.kind != Shape::Kind::none && touches(geom, paired)) {
        collision_.push_back(geom.shape);
        masks_.push_back(geom.mask);
        friction_ = std::max(friction_, geom.friction);
      }
      const bool solid = geom.shape.kind != Shape::Kind::none && !is_of_ground(geom.shape.kind);
      if (solid) (geom.hidden ? hidden_shapes_ : shapes_).push_back(std::move(geom.shape));
    } else if (name == "inertial") {
      if (inertial_) return reading_.file_of(child).error({child}, "a second <inertial> in one body", "leave one of them out");
      inertial_ = child;
    } else if (name == "frame" || name == "replicate" || name == "composite" || name == "flexcomp" || name == "attach" ||
               name == "plugin") {
      reading_.file_of(child).error({child}, child.tag() + " is not supported",
                                    "save the model as MuJoCo compiled it (mj_saveLastXML)");
    } else if (name == "site") {
      sites_.push_back(child);
    } else if (name != "camera" && name != "light") {
      reading_.file_of(child).once(Severity::note, child.tag() + " in <body> is ignored", "", {child});
    }
  }

  void add_mass_of(const Shape& mesh, const MeshMass& given, XmlElement element) {
    const auto refuse = [&](const std::string& problem, const std::string&) {
      reading_.file_of(element).error({element}, problem, "give the body an <inertial>, or the geom mass=\"0\"");
    };
    if (mesh.kind != Shape::Kind::mesh) return refuse("the inertia of this geom is not computed", "");
    std::optional<MassProperties> mass = io::mass_of(mesh, given.density, refuse);
    if (!mass) return;
    if (given.mass) mass = io::mass_of(mesh, given.density * *given.mass / mass->mass, refuse);
    masses_.push_back(*mass);
  }

  MassProperties mass_of() {
    using From = Compiler::FromGeoms;
    const From from = reading_.compiler.from_geoms;
    MassProperties mass;
    if (inertial_) mass = read_inertial(inertial_, reading_);
    if (from == From::always || (from == From::automatic && !inertial_)) {
      for (const auto& [element, shape, given] : meshes_) add_mass_of(shape, given, element);
      mass = sum_of(masses_);
    }
    const Compiler& compiler = reading_.compiler;
    if (compiler.boundmass > 0) mass.mass = std::max(mass.mass, compiler.boundmass);
    if (compiler.boundinertia > 0 || compiler.balanceinertia) {
      const auto moments = eigenvalues(mass.inertia);
      if (compiler.balanceinertia && moments[0] + moments[1] < moments[2])
        mass.inertia = diagonal((moments[0] + moments[1] + moments[2]) / 3);
      else if (moments[0] < compiler.boundinertia)
        mass.inertia = diagonal(std::max(compiler.boundinertia, moments[2]));  // large enough for any axes
    }
    return mass;
  }

  // The frames of the carriers and of the body coincide in the pose of the file.
  void place(const Joint& joint, std::size_t j, ImportedBody& body) {
    BodySpec& spec = body.spec;
    spec.joint = joint.spec;
    spec.joint_name = joint.name;
    if (j + 1 < joints_.size()) {
      spec.name = name_ + "." + (joint.name.empty() ? std::to_string(j + 1) : joint.name);
      if (spec.joint_name.empty()) spec.joint_name = spec.name;
      body.spots.body = joint.element;
    }
    body.limits = joint.limits;
    body.spots.joint = joint.element;
    body.spots.limits = joint.element;
    const Pose before = j == 0 ? pose_ : Pose{};
    if (joint.spec.kind == Kind::free) {
      const Quat& r = before.rotation;
      spec.q = {before.position.x, before.position.y, before.position.z, r.w, r.x, r.y, r.z};
      if (!spec.joint.parameters.stiffness.empty()) spec.joint.parameters.rest = spec.q;
      return;
    }
    spec.child_at = Pose(joint.anchor);
    spec.at = before * spec.child_at;
    if (joint.start == 0) return;
    // `ref`: the coordinate in that pose.
    spec.q = joint.start;
    const Vec3 axis = normalized(joint.spec.axis);
    if (joint.spec.kind == Kind::revolute)
      spec.at = spec.at * Pose(Vec3{}, from_axis_angle(axis, -joint.start));
    else
      spec.at = spec.at * Pose(-joint.start * axis);
  }

  XmlElement element_;
  Reading& reading_;
  XmlFile& file_;
  std::string name_, childclass_;
  Pose pose_{};
  std::vector<Joint> joints_;
  std::vector<MassProperties> masses_;
  std::vector<std::tuple<XmlElement, Shape, MeshMass>> meshes_;  // that have mass
  std::vector<Shape> collision_;
  std::vector<CollisionMask> masks_;
  std::vector<std::pair<std::string, double>> paired_;  // geoms of <pair>, with their friction
  double friction_ = -1;                                ///< negative: nothing touches
  std::vector<Shape> shapes_, hidden_shapes_;           ///< the hidden ones are drawn if there are no others
  std::vector<XmlElement> inner_, sites_;
  XmlElement inertial_{};
};

// A geom of the world is part of the ground. A plane that touches nothing says so of the floor that a scenario has there.
void read_world_geom(XmlElement element, const std::string& childclass, bool& floor_apart, Reading& reading) {
  Geom geom = read_geom(element, childclass, reading);
  ImportedSolids& ground = reading.import.model.ground;
  const auto name = element.find("name");
  const std::string own = name ? std::string(element.attribute(*name)) : std::string();
  if (name) reading.geoms[own] = {-1, geom.friction};
  if (geom.shape.kind == Shape::Kind::none) return;
  if (!touches(geom, name && reading.geoms_of_pairs.contains(own))) {
    floor_apart = floor_apart || geom.shape.kind == Shape::Kind::plane;
    return;
  }
  ground.collision.push_back(std::move(geom.shape));
  ground.masks.push_back(geom.mask);
  ground.friction = std::max(ground.friction, geom.friction);
}

}  // namespace

void read_world(XmlElement worldbody, Reading& reading) {
  struct Open {
    XmlElement element;
    std::string childclass;
    int parent;
  };
  std::vector<Open> open;  // a stack: the next one last
  const auto push = [&open](const std::vector<XmlElement>& bodies, const std::string& childclass, int parent) {
    for (auto body = bodies.rbegin(); body != bodies.rend(); ++body) open.push_back({*body, childclass, parent});
  };
  std::string childclass;
  if (const auto own = worldbody.find("childclass")) childclass = worldbody.attribute(*own);
  std::vector<XmlElement> bodies;
  bool floor_apart = false;
  for (const XmlElement child : children_of(worldbody, reading)) {
    const std::string_view name = child.name();
    if (name == "body")
      bodies.push_back(child);
    else if (name == "geom")
      read_world_geom(child, childclass, floor_apart, reading);
    else if (name == "site")
      read_site(child, childclass, "", -1, reading);
    else if (name == "frame" || name == "replicate" || name == "composite" || name == "flexcomp" || name == "attach")
      reading.file_of(child).error({child}, child.tag() + " is not supported",
                                   "save the model as MuJoCo compiled it (mj_saveLastXML)");
  }
  ImportedSolids& ground = reading.import.model.ground;
  if (floor_apart && ground.masks.empty()) ground.masks = {{0, 0}};
  push(bodies, childclass, -1);
  while (!open.empty()) {
    const Open next = open.back();
    open.pop_back();
    if (reading.import.model.bodies.size() >= Import::most_bodies)
      return reading.file_of(next.element).error({next.element}, "more than 1000000 bodies");
    BodyReader reader(next.element, next.childclass, Pose{}, reading);
    const int number = reader.add(next.parent);
    push(reader.inner(), reader.childclass(), number);
    if (reading.file_of(next.element).enough()) return;
  }
}

}  // namespace momentree::io::mjcf
