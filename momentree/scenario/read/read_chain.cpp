// The generator [mechanism.chain]: bodies and joints 1 … links along +x.
#include <algorithm>
#include <cmath>

#include <momentree/scenario/keys/joint_tables.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr Key chain_entries[] = {
    {"links", other(R"({"type": "integer", "minimum": 1, "maximum": 1000000})"), "Number of links", nullptr, "how many bodies"},
    {"length", number(dimension::length, Range::positive), "Distance between consecutive joints", nullptr,
     "between consecutive joints, such as \"5 cm\""},
    {"mass", number(dimension::mass), "Mass of each link", nullptr, "of one link, in kg, or a string such as \"10 g\""},
    {"inertia", moments,
     "Moments of inertia of each link about its centre of mass, in kg m^2 or strings with units: 1, 3 or 6 values", "0"},
    {"axis", vector(dimension::number), "Axis of every joint", "[0, 0, 1]"},
    {"angle", number(dimension::angle), "Initial angle of every joint", "0"},
    {"angle_growth", boolean, "Link k starts at k·angle", "false"},
    {"radius", number(dimension::length, Range::positive),
     "Radius of the links where they touch other bodies; default: they touch nothing"},
    {"shape", one_or_several(shape_table), "How each link is drawn; its frame is at the joint that carries it"},
};

struct Chain {
  int links = 0;
  double length = 1, mass = 1, angle = 0;
  JointParameters parameters{};
  bool angle_growth = false, angle_given = false;
  std::optional<double> radius{};
  Sym3 inertia{};
  Vec3 axis{0, 0, 1};
  Shape shape{};
};

BodySpec make_link(const Chain& chain, int k, const std::string& mechanism, bool free_root, const Pose& pose, BodyId parent) {
  BodySpec link;
  link.name = mechanism + "/" + std::to_string(k);
  link.mass = chain.mass;
  link.com = {chain.length / 2, 0, 0};
  link.inertia = chain.inertia;
  link.parent = parent;
  if (k == 1 && free_root) {
    link.joint.kind = Kind::free;
    const Quat& r = pose.rotation;
    link.q = {pose.position.x, pose.position.y, pose.position.z, r.w, r.x, r.y, r.z};
    return link;
  }
  link.joint.kind = Kind::revolute;
  link.joint.axis = chain.axis;
  link.joint.parameters = chain.parameters;
  link.at = k == 1 ? pose : Pose{chain.length, 0, 0};
  const double angle = chain.angle_growth ? k * chain.angle : chain.angle;
  if (chain.angle_given) link.q = {angle};
  if (auto& drive = link.joint.parameters.drive; drive && drive->moves()) {
    begin_motion(drive, angle, 0);
    const Curve::Point start = drive->motion[0].at(0);
    link.q = start.value, link.v = start.rate;
  }
  return link;
}

Chain read_fields(Fields& fields, Reading& reading) {
  Diagnostics& out = reading.out;
  const int most = reading.bodies_left;
  Chain chain;
  if (const Value* links = fields.require("links")) {
    if (most < 1 || (most < 1'000'000 && links->integer() && *links->integer() > most))
      out.error(links->place, "links: a scenario has at most 1000000 bodies, and here " + std::to_string(most) + " are left");
    else
      chain.links = static_cast<int>(read_whole(*links, "links", 1, most, out).value_or(chain.links));
  }
  fields.require("length");
  chain.length = fields.number("length").value_or(1);
  fields.require("mass");
  const std::size_t errors = out.errors();
  chain.mass = fields.number("mass").value_or(1);
  if (const Value* inertia = fields.find("inertia")) chain.inertia = read_inertia(*inertia, "inertia", out).value_or(Sym3{});
  if (errors != out.errors()) chain.mass = 1, chain.inertia = {};
  chain.axis = fields.vec3("axis").value_or(chain.axis);
  read_parameters(fields, &info(Kind::revolute), chain.parameters, out);
  chain.angle_given = fields.has("angle");
  chain.angle = fields.number("angle").value_or(0);
  chain.angle_growth = fields.boolean("angle_growth").value_or(false);
  chain.radius = fields.number("radius");
  if (chain.radius && !(2 * *chain.radius < chain.length))
    out.error(fields.place_of("radius"), "radius: the links would be thicker than they are long",
              "use less than half the length");
  if (const Value* shape = fields.find("shape")) chain.shape = read_shape(*shape, reading);
  if (chain.parameters.drive && chain.parameters.drive->moves() && fields.has("angle"))
    out.error(fields.place_of("angle"), "angle: the motion of these joints defines where they start", "leave it out");
  fields.finish();
  return chain;
}

}  // namespace

constinit const KeyTable chain_table{
    "[mechanism.chain]", "chain", "A generator: bodies and joints 1 … links along +x", chain_entries, {}, {}, true};

void read_chain(const Value& table, const std::string& mechanism, bool free_root, const Pose& pose, const MechanismState& state,
                JointTables& joints, std::size_t errors, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, chain_table, out);
  if (!table.table()) return;
  const Chain chain = read_fields(fields, reading);
  // The last revolute link represents all: they differ only in their angle, and its angle is the largest.
  const BodySpec any = make_link(chain, std::max(chain.links, 2), mechanism, free_root, pose, ground);
  for (const BodyProblem& problem : check_body(any))
    out.error(fields.place_of(problem.field == "q" ? "angle" : problem.field), problem.field + ": " + problem.what, problem.hint);
  if (any.mass >= 0) {
    const MassProblem problem = check_mass(any.mass, any.inertia);
    if (problem.warning)
      out.warning(fields.place_of("inertia"), problem.what, problem.hint);
    else if (!problem.what.empty())
      out.error(fields.place_of("inertia"), problem.what, problem.hint);
  }
  reading.bodies_left -= chain.links;

  const bool sound = errors == out.errors();
  // Names in a chain of unknown length are not checked, nor in a long one with errors, which should be refused quickly.
  if (!sound && (chain.links == 0 || chain.links > 10'000)) {
    reading.opaque.insert(mechanism);
    return;
  }
  if (sound) reading.scenario.model.reserve(reading.scenario.model.size() + chain.links);
  reading.bodies.reserve(reading.bodies.size() + static_cast<std::size_t>(chain.links));
  reading.joints.reserve(reading.joints.size() + static_cast<std::size_t>(chain.links));
  if (joints.any()) {
    std::vector<std::pair<std::string, Kind>> names;
    for (int k = 1; k <= chain.links; ++k)
      names.emplace_back(std::to_string(k), k == 1 && free_root ? Kind::free : Kind::revolute);
    joints.read(names);
  }
  BodyId parent = ground;
  std::size_t states_used = 0;
  for (int k = 1; k <= chain.links; ++k) {
    BodySpec link = make_link(chain, k, mechanism, free_root, pose, parent);
    const std::string number = joints.any() ? std::to_string(k) : std::string();
    joints.apply(number, link);
    if (!state.joints.empty()) {
      const auto found = state.joints.find(std::to_string(k));
      if (found != state.joints.end()) {
        ++states_used;
        check_start(joints, found->first, *found->second, out);
        read_joint_state(*found->second, found->first, link, out);
      }
    }
    joints.check(number, link);
    if (k == 1 && state.velocity) read_root_velocity(*state.velocity, link, out);
    reading.bodies.emplace(link.name, fields.place());
    reading.joints.emplace(link.name, fields.place());
    if (!sound || errors != out.errors()) continue;
    parent = reading.scenario.model.add_unjudged(std::move(link));
    if (chain.shape.kind != Shape::Kind::none) {
      reading.scenario.shapes.resize(static_cast<std::size_t>(reading.scenario.model.size()));
      reading.scenario.shapes.back() = chain.shape;
    }
    if (!chain.radius) continue;
    Collider collider;  // from joint to joint
    collider.body = parent;
    collider.solid = contact::capsule(*chain.radius, chain.length - 2 * *chain.radius,
                                      Pose(Vec3{chain.length / 2, 0, 0}, from_axis_angle({0, 1, 0}, std::acos(0.0))));
    reading.scenario.model.add_collider(std::move(collider));
  }
  if (states_used == state.joints.size() || chain.links == 0) return;
  for (const auto& [name, value] : state.joints)
    if (!reading.joints.contains(mechanism + "/" + name))
      out.error(value->place, "state: there is no joint " + in_quotes(name) + " in this chain",
                "the joints are 1 to " + std::to_string(chain.links));
}

}  // namespace momentree::io
