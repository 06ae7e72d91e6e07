// Converts the bodies of a mechanism into the values of a scenario.
#include <cmath>
#include <filesystem>
#include <system_error>

#include <momentree/model/start.hpp>
#include <momentree/models/mesh/source.hpp>
#include <momentree/scenario/convert/describe.hpp>

namespace momentree::io {

namespace {

using namespace document_values;
namespace fs = std::filesystem;

Value inertia_value(const Sym3& i) {
  if (i.xy != 0 || i.xz != 0 || i.yz != 0)
    return value(Value::Array{number(i.xx), number(i.yy), number(i.zz), number(i.xy), number(i.xz), number(i.yz)});
  if (i.xx == i.yy && i.yy == i.zz) return number(i.xx);
  return list(Vec3{i.xx, i.yy, i.zz});
}

bool any(const Sym3& i) { return i.xx != 0 || i.yy != 0 || i.zz != 0 || i.xy != 0 || i.xz != 0 || i.yz != 0; }

// The only size of a primitive, or a table of several.
Value primitive_value(const contact::Primitive& primitive) {
  struct {
    Value::Table table{};
    void operator()(const char* key, double x, const Field&) { add(table, key, number(x)); }
    void operator()(const char* key, const Vec3& x, const Field&) { add(table, key, list(x)); }
  } sizes;
  describe(sizes, primitive);
  return sizes.table.size() == 1 ? std::move(sizes.table.front().value) : value(std::move(sizes.table));
}

// The name of a shape's mesh in the text; empty if the text cannot name it.
std::string mesh_name(const Shape& shape, const MeshFolders& folders) {
  if (folders.names) {
    const auto named = shape.source ? folders.names->find(shape.source->key()) : folders.names->end();
    return named == folders.names->end() ? std::string() : named->second;
  }
  if (shape.source && (shape.source->path.empty() || !shape.source->submesh.empty())) return {};
  return mesh_path(shape.mesh, folders);
}

Value::Table one_shape(const Shape& shape, const MeshFolders& folders, LeftOut& left_out) {
  Value::Table table;
  switch (shape.kind) {
    case Shape::Kind::none:
    case Shape::Kind::heights: break;  // describe_collision() has its heights
    case Shape::Kind::plane: add(table, "plane", list(shape.size)); break;
    case Shape::Kind::primitive:
      if (!contact::has_volume(shape.primitive)) {
        ++left_out.flat;
        return table;
      }
      add(table, contact::info(shape.primitive).key, primitive_value(shape.primitive));
      break;
    case Shape::Kind::mesh: {
      const std::string mesh = mesh_name(shape, folders);
      if (mesh.empty()) {
        ++left_out.meshes;
        return table;
      }
      add(table, "mesh", text(mesh));
      const Vec3& s = shape.scale;
      if (s.x != 1 || s.y != 1 || s.z != 1) add(table, "scale", s.x == s.y && s.y == s.z ? number(s.x) : list(s));
      if (shape.split > 0) add(table, "split", number(shape.split));
      break;
    }
  }
  if (Value::Table at = placement(shape.at); !at.empty()) add(table, "at", value(std::move(at)));
  const bool in_mesh = folders.names && shape.source && !shape.source->colour.empty();  // the reader has it with the mesh
  if (!shape.colour.empty() && !in_mesh) add(table, "colour", text(shape.colour));
  return table;
}

// A root body that needs no joint table, because the mechanism's `root` describes it: fixed or free.
bool plain_root(const BodySpec& spec) {
  if (spec.joint_name != spec.name || spec.joint.parameters.any() || !placement(spec.child_at).empty()) return false;
  return spec.joint.kind == Kind::weld || (spec.joint.kind == Kind::free && placement(spec.at).empty());
}

void hold(Value::Table& table, const BodySpec& root, bool with_velocity) {
  const bool free = root.joint.kind == Kind::free;
  if (free) add(table, "root", text("free"));
  const Values q = start_coordinates(root);
  const Pose pose = free ? Pose{{q[0], q[1], q[2]}, {q[3], q[4], q[5], q[6]}} : root.at;
  if (Value::Table at = placement(pose); !at.empty()) add(table, "pose", value(std::move(at)));
  if (!free || !with_velocity || !root.v.any()) return;
  const Values& v = root.v;
  Value::Table velocity, state;
  const Vec3 linear{v[0], v[1], v[2]}, angular{v[3], v[4], v[5]};
  if (linear.x != 0 || linear.y != 0 || linear.z != 0) add(velocity, "linear", list(linear));
  if (angular.x != 0 || angular.y != 0 || angular.z != 0) add(velocity, "angular", list(angular));
  add(state, "velocity", value(std::move(velocity)));
  add(table, "state", value(std::move(state)));
}

}  // namespace

std::string mesh_path(const std::string& mesh, const MeshFolders& folders) {
  if (folders.from.empty() && folders.to.empty()) return mesh;
  std::error_code failed;
  const fs::path file = fs::path(folders.from.empty() ? "." : folders.from) / mesh;
  if (!fs::is_regular_file(file, failed)) return {};
  const fs::path path = fs::proximate(file, folders.to.empty() ? "." : folders.to, failed);
  if (failed || path.is_absolute() || path.empty() || *path.begin() == "..") return {};
  return path.generic_string();
}

Value describe_shape(const Shape& shape, const MeshFolders& folders, LeftOut& left_out) {
  Value::Array all;
  const auto take = [&](const Shape& each) {
    if (Value::Table table = one_shape(each, folders, left_out); table.size() > 0) all.push_back(value(std::move(table)));
  };
  take(shape);
  for (const Shape& each : shape.more) take(each);
  if (all.empty()) return {};
  return all.size() == 1 ? std::move(all.front()) : value(std::move(all));
}

Value::Table describe_mechanism(const std::string& name, const Model& model, std::span<const int> bodies,
                                std::span<const Shape> shapes, const MeshFolders& folders, const std::string& state,
                                LeftOut& left_out) {
  Value::Table table;
  add(table, "name", text(name));
  std::int64_t roots = 0;
  for (const int b : bodies) roots += model[BodyId{b}].parent == ground;
  if (roots > 1) add(table, "roots", value(roots));
  const BodySpec& first = model[BodyId{bodies.front()}];
  const bool held = roots == 1 && plain_root(first) && (state.empty() || !first.v.any());
  if (held) hold(table, first, true);
  if (!state.empty()) add(table, "state", text(state));
  Value::Array list_of_bodies;
  for (const int b : bodies) {
    const BodySpec& spec = model[BodyId{b}];
    Value::Table body;
    add(body, "name", text(bare(spec.name)));
    add(body, "mass", number(spec.mass));
    if (spec.com.x != 0 || spec.com.y != 0 || spec.com.z != 0) add(body, "com", list(spec.com));
    if (any(spec.inertia)) add(body, "inertia", inertia_value(spec.inertia));
    const auto number_of = static_cast<std::size_t>(b);
    if (number_of < shapes.size()) {
      Value shape = describe_shape(shapes[number_of], folders, left_out);
      if (!shape.table() || !shape.table()->empty()) add(body, "shape", std::move(shape));
    }
    if (!(held && spec.parent == ground))
      add(body, "joint",
          value(describe_joint(spec, spec.joint_name == spec.name ? "" : bare(spec.joint_name),
                               spec.parent == ground ? "" : bare(model[spec.parent].name))));
    list_of_bodies.push_back(value(std::move(body)));
  }
  add(table, "body", value(std::move(list_of_bodies)));
  return table;
}

Value::Table describe_force(const BodyForce& force, const Model& model) {
  Value::Table table;
  add(table, "body", text(model[force.body].name));
  if (force.point.x != 0 || force.point.y != 0 || force.point.z != 0) add(table, "point", list(force.point));
  if (force.body_axes) add(table, "axes", text("body"));
  const auto components = [&](const char* key, const std::array<Signal, 3>& signals) {
    Value::Array all;
    bool given = false;
    for (const Signal& signal : signals) {
      given = given || !signal.constant() || signal.value(0) != 0;
      all.push_back(describe_signal(signal));
    }
    if (given) add(table, key, value(std::move(all)));
    return given;
  };
  const bool pulls = components("force", force.force), turns = components("torque", force.torque);
  if (force.drag.any() || (!pulls && !turns)) {
    Value::Table drag;
    if (force.drag.linear != 0 || force.drag.quadratic == 0) add(drag, "linear", number(force.drag.linear));
    if (force.drag.quadratic != 0) add(drag, "quadratic", number(force.drag.quadratic));
    if (force.drag.quadratic != 0 && force.drag.area != 1) add(drag, "area", number(force.drag.area));
    add(table, "drag", value(std::move(drag)));
  }
  return table;
}

}  // namespace momentree::io
