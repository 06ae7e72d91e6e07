// An animated glTF 2.0 file (.glb).
//
// The root node turns the world so that gravity points along −y. Below it, each body has a node with its name, whose translation
// and rotation have a key at each row; times are relative to the first row, in single precision. Below a body are its solids.
// If its mechanism changes, those in mechanism colours are there once for each colour: scales of 1 and 0, which change in steps,
// show the present one. Bars are nodes of their own. Extras: of the scene the start, the status and the events; of a body the
// mechanisms to which it belongs, and from when on.
#include <algorithm>
#include <cmath>
#include <map>

#include <momentree/export/exporter.hpp>
#include <momentree/export/gltf_document.hpp>
#include <momentree/export/solids.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

namespace {

Float3 single(const Vec3& v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }
Float4 single(const Quat& q) {
  return {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z), static_cast<float>(q.w)};
}

/// One after another, `width` numbers each.
bool all_equal(const std::vector<float>& values, std::size_t width) {
  for (std::size_t i = width; i < values.size(); ++i)
    if (values[i] != values[i - width]) return false;
  return true;
}

template <std::size_t width>
std::array<float, width> first_of(const std::vector<float>& values) {
  std::array<float, width> first{};
  std::copy_n(values.begin(), width, first.begin());
  return first;
}

class GlbBuilder {
 public:
  explicit GlbBuilder(const Drawing& drawing) : drawing_(drawing) {}

  std::string build() {
    choose_keys();
    const Vec3& g = drawing_.run.gravity;
    const Vec3 up = norm(g) > 0 ? normalized(-g) : Vec3{0, 0, 1};
    root_ = file_.add_node({.name = "world", .rotation = single(shortest_turn(up, {0, 1, 0}))}, -1);
    for (std::size_t b = 0; b < drawing_.run.bodies.size(); ++b) add_body(b);
    for (const Bar& bar : drawing_.bars) add_bar(bar);
    write_extras();
    return file_.binary("momentree " MOMENTREE_VERSION, drawing_.run.title);
  }

 private:
  float since_start(double time) const { return static_cast<float>(std::clamp(time - drawing_.times.front(), 0.0, 1e30)); }

  void choose_keys() {
    std::vector<float> times;
    for (const auto& [time, row] : keys_of<float>(drawing_, [this](double t) { return since_start(t); }))
      times.push_back(time), rows_.push_back(row);
    end_ = times.back();
    times_ = file_.add_times(times);
  }

  /// The node's values at the first key, and its animation unless they stay the same.
  template <std::size_t width>
  void animate(int node, GltfDocument::Path path, const std::vector<float>& values) {
    if (!all_equal(values, width)) file_.animate(node, path, times_, values, false);
  }

  void add_body(std::size_t b) {
    using Path = GltfDocument::Path;
    std::vector<float> places, turns;
    for (const std::size_t row : rows_) {
      const double* const p = drawing_.pose(row, b);
      for (const std::size_t k : {0u, 1u, 2u}) places.push_back(static_cast<float>(p[k]));
      for (const std::size_t k : {4u, 5u, 6u, 3u}) turns.push_back(static_cast<float>(p[k]));
    }
    const int node = file_.add_node({.name = drawing_.run.bodies[b].name,
                                     .translation = first_of<3>(places),
                                     .rotation = first_of<4>(turns),
                                     .extras = mechanisms_of(b)},
                                    root_);
    nodes_.push_back(node);
    animate<3>(node, Path::translation, places);
    animate<4>(node, Path::rotation, turns);

    std::vector<std::string> colours;  // by colouring
    for (const Colouring& colouring : drawing_.colourings) colours.push_back(Drawing::colour_of(colouring.mechanism[b]));
    const bool constant = std::all_of(colours.begin(), colours.end(), [&](const auto& each) { return each == colours.front(); });
    std::map<std::string, int> variants;
    for (const Solid& solid : drawing_.solids[b]) {
      if (!solid.colour.empty() || constant) {
        add_solid(solid, solid.colour.empty() ? colours.front() : solid.colour, node);
        continue;
      }
      if (variants.empty())
        for (const std::string& colour : colours)
          if (!variants.contains(colour)) variants[colour] = add_variant(b, colours, colour, node);
      for (const auto& [colour, variant] : variants) add_solid(solid, colour, variant);
    }
  }

  std::string mechanisms_of(std::size_t b) const {
    std::string text;
    JsonWriter json(text);
    json.begin_object().key("mechanisms").begin_array();
    int before = -1;
    for (const Colouring& colouring : drawing_.colourings) {
      const int mechanism = colouring.mechanism[b];
      if (mechanism != before)
        json.begin_object()
            .member("from", colouring.from - drawing_.times.front())
            .member("name", drawing_.run.mechanisms[static_cast<std::size_t>(mechanism)])
            .end_object();
      before = mechanism;
    }
    json.end_array().end_object();
    return text;
  }

  /// The node of a body's solids in this colour.
  int add_variant(std::size_t b, const std::vector<std::string>& colours, const std::string& colour, int parent) {
    std::vector<std::pair<double, bool>> shown;
    for (std::size_t i = 0; i < colours.size(); ++i) shown.emplace_back(drawing_.colourings[i].from, colours[i] == colour);
    return add_switched(drawing_.run.bodies[b].name + " " + colour, shown, parent);
  }

  /// A node that is shown or hidden from these times on (s); hidden before the first.
  int add_switched(const std::string& name, const std::vector<std::pair<double, bool>>& shown, int parent) {
    std::vector<float> times{0}, scales;
    std::vector<bool> states{false};
    for (const auto& [from, state] : shown) {
      const float time = since_start(from);
      if (time > end_) break;
      if (time <= times.back())
        states.back() = state;
      else if (states.back() != state)
        times.push_back(time), states.push_back(state);
    }
    for (const bool state : states) scales.insert(scales.end(), 3, state ? 1.0f : 0.0f);
    const int node = file_.add_node({.name = name, .scale = first_of<3>(scales)}, parent);
    if (states.size() > 1) {
      const auto known = switch_times_.find(times);
      const int input = known != switch_times_.end() ? known->second : file_.add_times(times);
      switch_times_[times] = input;
      file_.animate(node, GltfDocument::Path::scale, input, scales, true);
    }
    return node;
  }

  int mesh_of(const Solid& solid, const std::string& colour) {
    const bool mesh = solid.kind == Solid::Kind::mesh, capsule = solid.kind == Solid::Kind::capsule;
    const GeometryKey key{static_cast<int>(solid.kind), solid.mesh, capsule ? solid.size.x : 0, capsule ? solid.size.z : 0};
    auto triangles = geometries_.find(key);
    if (triangles == geometries_.end()) {
      Triangles made;
      switch (solid.kind) {
        case Solid::Kind::box: made = unit_box(); break;
        case Solid::Kind::ellipsoid: made = unit_sphere(); break;
        case Solid::Kind::cylinder: made = unit_cylinder(); break;
        case Solid::Kind::capsule: made = capsule_of(0.5 * solid.size.x, solid.size.z); break;
        case Solid::Kind::mesh: made = triangles_of(drawing_.run.mesh_parts[static_cast<std::size_t>(solid.mesh)]); break;
      }
      triangles = geometries_.emplace(key, file_.add_triangles(made)).first;
    }
    const std::pair<int, int> wanted{triangles->second, file_.material(colour, mesh)};
    const auto known = meshes_.find(wanted);
    if (known != meshes_.end()) return known->second;
    return meshes_[wanted] = file_.add_mesh(wanted.first, wanted.second);
  }

  void add_solid(const Solid& solid, const std::string& colour, int parent) {
    GltfDocument::Node node{
        .mesh = mesh_of(solid, colour), .translation = single(solid.at.position), .rotation = single(solid.at.rotation)};
    if (solid.kind != Solid::Kind::capsule) node.scale = single(solid.size);
    static constexpr const char* names[] = {"box", "ellipsoid", "cylinder", "capsule", "mesh"};
    node.name = names[static_cast<int>(solid.kind)];
    file_.add_node(std::move(node), parent);
  }

  void add_bar(const Bar& bar) {
    using Path = GltfDocument::Path;
    const bool fixed = bar.from == bar.to && bar.from >= 0;
    std::vector<std::pair<double, bool>> shown{{bar.begin, true}};
    if (bar.end < 1e300) shown.emplace_back(bar.end, false);
    const int parent = add_switched(bar.name, shown, fixed ? nodes_[static_cast<std::size_t>(bar.from)] : root_);
    std::vector<float> places, turns, scales;
    BarPoses poses;
    const auto add_key = [&](const Vec3& from, const Vec3& to) {
      const Pose pose = poses.next(from, to);
      for (const float x : single(pose.position)) places.push_back(x);
      for (const float x : single(pose.rotation)) turns.push_back(x);
      for (const float x : single(bar_scale(bar.radius, from, to))) scales.push_back(x);
    };
    if (fixed)
      add_key(bar.from_point, bar.to_point);
    else
      for (const std::size_t row : rows_)
        add_key(drawing_.place(row, bar.from, bar.from_point), drawing_.place(row, bar.to, bar.to_point));
    const int node = file_.add_node({.name = "bar",
                                     .mesh = mesh_of({.kind = Solid::Kind::cylinder}, bar.colour),
                                     .translation = first_of<3>(places),
                                     .rotation = first_of<4>(turns),
                                     .scale = first_of<3>(scales)},
                                    parent);
    if (fixed) return;
    animate<3>(node, Path::translation, places);
    animate<4>(node, Path::rotation, turns);
    animate<3>(node, Path::scale, scales);
  }

  void write_extras() {
    std::string text;
    JsonWriter json(text);
    json.begin_object().member("start", drawing_.times.front());
    if (!drawing_.status.empty()) json.member("status", drawing_.status);
    json.key("events").begin_array();
    for (const RecordedEvent& event : drawing_.run.events) {
      json.begin_object().member("time", event.time - drawing_.times.front()).member("event", event.name);
      json.key("actions").begin_array();
      for (const std::string& action : event.actions) json.value(action);
      json.end_array().end_object();
    }
    json.end_array().end_object();
    file_.set_extras(std::move(text));
  }

  struct GeometryKey {
    int kind, mesh;
    double diameter, length;
    auto operator<=>(const GeometryKey&) const = default;
  };

  const Drawing& drawing_;
  GltfDocument file_;
  std::vector<std::size_t> rows_;  ///< by key
  int times_ = -1, root_ = -1;
  float end_ = 0;
  std::vector<int> nodes_;  ///< by body
  std::map<GeometryKey, int> geometries_;
  std::map<std::pair<int, int>, int> meshes_;  ///< by triangles and material
  std::map<std::vector<float>, int> switch_times_;
};

/// Throws Error, without a place, if it would have more than 4 GiB.
std::string glb_of(const Drawing& drawing) { return GlbBuilder(drawing).build(); }

}  // namespace

Exporter exporters::glb() {
  return {.ending = ".glb", .format = "glTF", .content = "animated glTF", .readers = "3D programs", .bytes = &glb_of};
}

}  // namespace momentree::io
