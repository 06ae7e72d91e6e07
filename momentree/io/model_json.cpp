#include <momentree/io/model_json.hpp>

#include <utility>

#include <momentree/io/json_writer.hpp>

namespace momentree::io {
namespace {

using Edge3 = std::pair<Vec3, Vec3>;

/// By body.
std::vector<std::vector<Edge3>> drawn_extents(const Model& model, const std::vector<Shape>& shapes) {
  std::vector<std::vector<Edge3>> extents(static_cast<std::size_t>(model.size()));
  for (const BodySpec& child : model.bodies()) {
    if (child.parent == ground) continue;
    const Vec3 from = model[child.parent].child_at.position;
    if (norm(child.at.position - from) > 0)
      extents[static_cast<std::size_t>(child.parent.index)].emplace_back(from, child.at.position);
  }
  for (int b = 0; b < model.size(); ++b) {
    const BodySpec& body = model[Body{b}];
    const Vec3 from = body.child_at.position;
    auto& extent = extents[static_cast<std::size_t>(b)];
    const bool shaped =
        static_cast<std::size_t>(b) < shapes.size() && shapes[static_cast<std::size_t>(b)].kind != Shape::Kind::none;
    if (extent.empty() && norm(body.com - from) > 0) extent.emplace_back(from, from + (shaped ? 1.0 : 2.0) * (body.com - from));
  }
  return extents;
}

void write_pose(JsonWriter& json, const char* key, const Pose& pose) {
  json.key(key).begin_object().member("xyz", pose.position).member("quat", pose.rotation).end_object();
}

void write_shape(JsonWriter& json, const Shape& shape) {
  using Kind = Shape::Kind;
  if (shape.kind == Kind::none) {
    json.null();
    return;
  }
  constexpr const char* names[] = {"none", "box", "sphere", "cylinder", "capsule", "mesh"};
  json.begin_object().member("kind", names[static_cast<int>(shape.kind)]);
  if (shape.kind == Kind::box) json.member("size", shape.size);
  if (shape.kind == Kind::sphere || shape.kind == Kind::cylinder || shape.kind == Kind::capsule)
    json.member("radius", shape.radius);
  if (shape.kind == Kind::cylinder || shape.kind == Kind::capsule) json.member("length", shape.length);
  if (shape.kind == Kind::mesh) json.member("file", shape.mesh);
  if (shape.kind == Kind::mesh && !(shape.scale == Vec3{1, 1, 1})) json.member("scale", shape.scale);
  write_pose(json, "at", shape.at);
  if (!shape.colour.empty()) json.member("colour", shape.colour);
  json.end_object();
}

void write_joint(JsonWriter& json, const Model& model, const BodySpec& body) {
  const KindInfo& kind = info(body.joint.kind);
  json.key(body.joint_name).begin_object().member("kind", kind.name).key("parent");
  if (body.parent == ground)
    json.null();
  else
    json.value(model[body.parent].name);
  json.member("child", body.name);
  write_pose(json, "at", body.at);
  write_pose(json, "child_at", body.child_at);
  if (kind.axis) json.member("axis", body.joint.axis);
  if (kind.axis2) json.member("axis2", body.joint.axis2);
  if (kind.pitch) json.member("pitch", body.joint.pitch);
  json.end_object();
}

/// The root of each body's tree at the start: parents come before children.
std::vector<int> roots(const Model& model) {
  std::vector<int> root(static_cast<std::size_t>(model.size()));
  for (int b = 0; b < model.size(); ++b) {
    const Body parent = model[Body{b}].parent;
    root[static_cast<std::size_t>(b)] = parent == ground ? b : root[static_cast<std::size_t>(parent.index)];
  }
  return root;
}

void write_mechanisms(JsonWriter& json, const Model& model) {
  const std::vector<int> root = roots(model);
  std::vector<std::vector<int>> members(root.size());
  for (std::size_t b = 0; b < root.size(); ++b) members[static_cast<std::size_t>(root[b])].push_back(static_cast<int>(b));
  json.key("mechanisms").begin_array();
  for (std::size_t r = 0; r < members.size(); ++r) {
    if (members[r].empty()) continue;
    const Body body{static_cast<int>(r)};
    json.begin_object().member("name", model.mechanism_name(body)).member("root", model[body].name).key("bodies").begin_array();
    for (const int b : members[r]) json.value(model[Body{b}].name);
    json.end_array().end_object();
  }
  json.end_array();
}

}  // namespace

std::string model_json(const Model& model, const std::string& title, const std::vector<Shape>& shapes) {
  std::string text;
  JsonWriter json(text, 2);
  json.begin_object().member("format", 1).member("title", title).member("gravity", model.gravity());
  write_mechanisms(json, model);
  const auto extents = drawn_extents(model, shapes);
  json.key("bodies").begin_object();
  for (int b = 0; b < model.size(); ++b) {
    const auto n = static_cast<std::size_t>(b);
    const BodySpec& body = model[Body{b}];
    const Sym3& I = body.inertia;
    const double inertia[6] = {I.xx, I.yy, I.zz, I.xy, I.xz, I.yz};
    json.key(body.name).begin_object().member("joint", body.joint_name).member("mass", body.mass).member("com", body.com);
    json.member("inertia", std::span<const double>(inertia)).key("extent").begin_array();
    for (const auto& [from, to] : extents[n]) json.begin_array().value(from).value(to).end_array();
    json.end_array().key("shape");
    const Shape shape = n < shapes.size() ? shapes[n] : Shape{};
    write_shape(json, shape);
    if (!shape.more.empty()) {
      json.key("more_shapes").begin_array();
      for (const Shape& each : shape.more) write_shape(json, each);
      json.end_array();
    }
    json.end_object();
  }
  json.end_object().key("joints").begin_object();
  for (const BodySpec& body : model.bodies()) write_joint(json, model, body);
  json.end_object().end_object();
  text += '\n';
  return text;
}

}  // namespace momentree::io
