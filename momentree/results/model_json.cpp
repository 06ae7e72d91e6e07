#include <momentree/results/model_json.hpp>

#include <algorithm>

#include <unordered_map>
#include <utility>

#include <momentree/models/mesh/source.hpp>
#include <momentree/scenario/keys/described.hpp>
#include <momentree/scenario/read/collider_shapes.hpp>
#include <momentree/scenario/state/joint_json.hpp>
#include <momentree/simulate/events/topology_record.hpp>

namespace momentree::io {
namespace {

using Edge3 = std::pair<Vec3, Vec3>;

/// The extents of all bodies, by body number.
std::vector<std::vector<Edge3>> drawn_extents(const World& world, const std::vector<Shape>& shapes) {
  const Model& model = world.model();
  std::vector<std::vector<Edge3>> extents(static_cast<std::size_t>(model.size()));
  const auto reach = [&](BodyId body, const Vec3& point) {  // from the inboard joint, unless there is such a line
    const Edge3 line{model[body].child_at.position, point};
    auto& own = extents[static_cast<std::size_t>(body.index)];
    if (norm(line.second - line.first) > 0 && std::find(own.begin(), own.end(), line) == own.end()) own.push_back(line);
  };
  for (const BodySpec& child : model.bodies()) {
    if (child.parent == ground) continue;
    const Vec3 from = model[child.parent].child_at.position;
    if (norm(child.at.position - from) > 0)
      extents[static_cast<std::size_t>(child.parent.index)].emplace_back(from, child.at.position);
  }
  for (const JointId loop : world.loops()) {
    const JointView joint = world.joint(loop);
    reach(joint.child, joint.child_at.position);
    if (joint.parent != ground) reach(joint.parent, joint.at.position);
  }
  for (int b = 0; b < model.size(); ++b) {
    const BodySpec& body = model[BodyId{b}];
    const Vec3 from = body.child_at.position;
    auto& extent = extents[static_cast<std::size_t>(b)];
    const bool shaped =
        static_cast<std::size_t>(b) < shapes.size() && shapes[static_cast<std::size_t>(b)].kind != Shape::Kind::none;
    if (extent.empty() && norm(body.com - from) > 0) extent.emplace_back(from, from + (shaped ? 1.0 : 2.0) * (body.com - from));
  }
  return extents;
}

// By the key of their sources.
using MeshNumbers = std::unordered_map<std::string, int>;

template <class F>
void each_source(const std::vector<Shape>& shapes, const F& f) {
  for (const Shape& shape : shapes) {
    if (shape.source) f(shape.source);
    for (const Shape& each : shape.more)
      if (each.source) f(each.source);
  }
}

// `inside`: the triangles of a mesh that has no number. Those of primitives that viewers do not have are written, too.
void write_shape(JsonWriter& json, const Model& model, const Shape& shape, const MeshNumbers& numbers, MeshPart inside = {}) {
  using Kind = Shape::Kind;
  if (shape.kind == Kind::none) {
    json.null();
    return;
  }
  json.begin_object().member("kind", shape.kind == Kind::mesh ? "mesh" : contact::info(shape.primitive).key);
  if (shape.kind == Kind::primitive) {
    MemberWriter members(json, model);
    describe(members, shape.primitive);
    if (!contact::standard(shape.primitive)) inside = surface_of(contact::solid(shape.primitive, {}));
  }
  if (!inside.points.empty()) {
    json.key("points").begin_array();
    for (const Vec3& point : inside.points) json.value(point);
    json.end_array().key("triangles").begin_array();
    for (const auto& [a, b, c] : inside.triangles)
      json.begin_array().value(static_cast<long>(a)).value(static_cast<long>(b)).value(static_cast<long>(c)).end_array();
    json.end_array();
  } else if (shape.kind == Kind::mesh) {
    json.member("file", shape.mesh);
  }
  if (shape.kind == Kind::mesh && shape.source) json.member("mesh", numbers.at(shape.source->key()));
  if (shape.kind == Kind::mesh && !(shape.scale == Vec3{1, 1, 1})) json.member("scale", shape.scale);
  write_pose(json, "at", shape.at);
  const bool in_mesh = shape.source && !shape.source->colour.empty();  // among those of the mesh
  if (!shape.colour.empty() && !in_mesh) json.member("colour", shape.colour);
  json.end_object();
}

void write_mechanisms(JsonWriter& json, const World& world) {
  const Model& model = world.model();
  json.key("mechanisms").begin_array();
  for (Mechanism& mechanism : world.mechanisms()) {
    std::sort(mechanism.bodies.begin(), mechanism.bodies.end(), [](BodyId a, BodyId b) { return a.index < b.index; });
    json.begin_object().member("name", mechanism.name).member("root", model[mechanism.root].name).key("bodies").begin_array();
    for (const BodyId body : mechanism.bodies) json.value(model[body].name);
    json.end_array().end_object();
  }
  json.end_array();
}

// `model.json` of a model without planes or other ground has no such members.
void write_ground(JsonWriter& json, const Model& model) {
  bool any = false;
  for (const Collider& collider : model.colliders()) {
    if (!collider.plane) continue;
    if (!any) json.key("planes").begin_array();
    any = true;
    json.begin_object().member("point", collider.point).member("normal", collider.normal).end_object();
  }
  if (any) json.end_array();
  const std::vector<GroundShape> shapes = ground_shapes(model);
  if (shapes.empty()) return;
  json.key("ground").begin_array();
  for (const auto& [shape, mesh] : shapes) write_shape(json, model, shape, {}, mesh);
  json.end_array();
}

// `model.json` of a model without springs has no such member.
void write_springs(JsonWriter& json, const World& world) {
  const Model& model = world.model();
  if (model.springs().empty()) return;
  json.key("springs").begin_object();
  for (int s = 0; s < world.springs(); ++s) {
    const SpringView spring = world.spring({s});
    json.key(spring.name).begin_object();
    MemberWriter members(json, model);
    describe(members, spring);
    json.end_object();
  }
  json.end_object();
}

}  // namespace

std::string model_json(const World& world, const std::string& title, const std::vector<Shape>& given) {
  const Model& model = world.model();
  const std::vector<Shape> shapes = drawn_shapes(model, given);
  std::string text;
  JsonWriter json(text, 2);
  json.begin_object().member("format", 1).member("title", title).member("gravity", model.gravity());
  write_mechanisms(json, world);
  const auto extents = drawn_extents(world, shapes);
  MeshNumbers meshes;
  each_source(shapes, [&](const auto& source) { meshes.emplace(source->key(), static_cast<int>(meshes.size())); });
  json.key("bodies").begin_object();
  for (int b = 0; b < model.size(); ++b) {
    if (!world.alive({b})) continue;  // removed
    const auto n = static_cast<std::size_t>(b);
    const BodySpec& body = model[BodyId{b}];
    const Sym3& I = body.inertia;
    const double inertia[6] = {I.xx, I.yy, I.zz, I.xy, I.xz, I.yz};
    json.key(body.name)
        .begin_object()
        .member("joint", world.joint_name(world.tree().inboard_joint({b})))
        .member("mass", body.mass)
        .member("com", body.com);
    json.member("inertia", std::span<const double>(inertia)).key("extent").begin_array();
    for (const auto& [from, to] : extents[n]) json.begin_array().value(from).value(to).end_array();
    json.end_array().key("shape");
    const Shape shape = n < shapes.size() ? shapes[n] : Shape{};
    const auto write_shapes = [&](const char* key, const std::vector<Shape>& all) {
      if (all.empty()) return;
      json.key(key).begin_array();
      for (const Shape& each : all) write_shape(json, model, each, meshes);
      json.end_array();
    };
    write_shape(json, model, shape, meshes);
    write_shapes("more_shapes", shape.more);
    if (n < given.size() && given[n].kind == Shape::Kind::mesh && shape.kind != Shape::Kind::mesh) {
      std::vector<Shape> missing = given[n].more;
      missing.insert(missing.begin(), given[n]);
      write_shapes("missing_shapes", missing);
    }
    json.end_object();
  }
  json.end_object().key("joints").begin_object();
  for (const JointId number : present_joints(world)) {
    const JointRecord joint = joint_record(world, number);
    json.key(joint.name).begin_object();
    write_joint_frame(json, joint);
    json.end_object();
  }
  json.end_object();
  write_ground(json, model);
  write_springs(json, world);
  json.end_object();
  text += '\n';
  return text;
}

std::vector<std::shared_ptr<const MeshSource>> mesh_sources(const std::vector<Shape>& shapes) {
  MeshNumbers numbers;
  std::vector<std::shared_ptr<const MeshSource>> sources;
  each_source(shapes, [&](const auto& source) {
    if (numbers.emplace(source->key(), static_cast<int>(numbers.size())).second) sources.push_back(source);
  });
  return sources;
}

}  // namespace momentree::io
