#include <momentree/export/picture/scene.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string_view>

#include <momentree/contact/shapes/feature.hpp>
#include <momentree/export/picture/outline.hpp>
#include <momentree/joint/joint.hpp>

namespace momentree::io {
namespace {

/// Whether there is a joint to draw: a free joint constrains nothing, and a weld allows no motion.
bool moves(const KindInfo* kind) { return kind != nullptr && kind->nv > 0 && kind->nv < 6; }

/// Whether the joint can separate the two origins of its frame.
bool displaces(const KindInfo* kind) {
  return moves(kind) && (kind->pitch || std::string_view(kind->v_units).find('m') != std::string_view::npos);
}

/// A part of a shape's outline: the hull of the points, enlarged by `radius`. Flat parts have a normal, and are visible only
/// from outside.
struct Patch {
  std::vector<Vec3> points;
  double radius = 0;
  Vec3 normal{};
};

void add_box(const Vec3& size, std::vector<Patch>& patches) {
  const Vec3 half = 0.5 * size;
  const Vec3 axes[3] = {{half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z}};
  for (std::size_t k = 0; k < 3; ++k)
    for (const double side : {-1.0, 1.0}) {
      const Vec3 centre = side * axes[k], &u = axes[(k + 1) % 3], &v = axes[(k + 2) % 3];
      patches.push_back({{centre - u - v, centre + u - v, centre + u + v, centre - u + v}, 0, centre});
    }
}

void add_cylinder(double radius, double length, std::vector<Patch>& patches) {
  constexpr int around = 32;
  Patch side, caps[2];
  for (const int end : {0, 1}) {
    const double z = (end - 0.5) * length;
    caps[end].normal = {0, 0, z};
    for (int k = 0; k < around; ++k) {
      const double a = 2 * std::numbers::pi * k / around;
      caps[end].points.push_back({radius * std::cos(a), radius * std::sin(a), z});
    }
    side.points.insert(side.points.end(), caps[end].points.begin(), caps[end].points.end());
  }
  patches.insert(patches.end(), {side, caps[0], caps[1]});
}

void add_ellipsoid(const Vec3& axes, std::vector<Patch>& patches) {
  constexpr int around = 32;
  Patch& skin = patches.emplace_back();
  for (int i = 0; i <= around / 2; ++i)
    for (int k = 0; k < around; ++k) {
      const double down = 2 * std::numbers::pi * i / around, a = 2 * std::numbers::pi * k / around;
      skin.points.push_back(
          {axes.x * std::sin(down) * std::cos(a), axes.y * std::sin(down) * std::sin(a), axes.z * std::cos(down)});
    }
}

/// The parts of a shape, in its own axes. Empty for a mesh.
std::vector<Patch> patches_of(const Shape& shape) {
  std::vector<Patch> patches;
  if (shape.kind != Shape::Kind::primitive) return patches;
  if (const auto* box = shape.as<contact::Box>()) {
    add_box(box->size, patches);
  } else if (const auto* ellipsoid = shape.as<contact::Ellipsoid>()) {
    add_ellipsoid(ellipsoid->semi_axes, patches);
  } else if (const auto* cylinder = shape.as<contact::Cylinder>()) {
    add_cylinder(cylinder->radius, cylinder->length, patches);
  } else {
    const contact::Solid solid = contact::solid(shape.primitive, {});
    patches.push_back(solid.is_smooth() ? Patch{surface_of(solid).points} : Patch{solid.vertices, solid.radius});
  }
  return patches;
}

/// Calls back with each shape of a body, and with the parts of its mesh, if it is one.
template <class Action>
void for_each_shape(const Recording& run, const RecordedBody& body, const Action& action) {
  const auto parts_of = [&](std::size_t place) -> std::span<const MeshPart> {
    const auto [first, count] = run.parts_of(body, place);
    return std::span(run.mesh_parts).subspan(first, count);
  };
  action(body.shape, parts_of(0));
  for (std::size_t i = 0; i < body.shape.more.size(); ++i) action(body.shape.more[i], parts_of(i + 1));
}

Vec3 scaled(const Shape& shape, const Vec3& p) { return {shape.scale.x * p.x, shape.scale.y * p.y, shape.scale.z * p.z}; }

constexpr const char* spring_colour = "#6b7684";

Vec3 spring_end(const RecordedFrame& frame, int body, const Vec3& point) {
  return body < 0 ? point : frame.poses[static_cast<std::size_t>(body)] * point;
}

double distance(const Point2& a, const Point2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

constexpr const char* ground_colour = "#aab2bd";

double mean_depth(const View& view, const std::vector<Vec3>& points) {
  double depth = 0;
  for (const Vec3& p : points) depth += view.depth(p) / static_cast<double>(points.size());
  return depth;
}

/// Appends the areas and outlines of a shape that are seen. `like`: their mechanism and colour.
void append_shape(const Shape& shape, std::span<const MeshPart> parts, const Pose& pose, const View& view, const Primitive& like,
                  std::vector<Primitive>& out) {
  const Pose placed = pose * shape.at;
  for (const MeshPart& part : parts) {
    std::vector<Vec3> points;
    std::vector<Point2> seen;
    for (const Vec3& p : part.points) seen.push_back(view(points.emplace_back(placed * scaled(shape, p))));
    Primitive outline = like;
    outline.kind = Primitive::Kind::outline, outline.depth = mean_depth(view, points);
    if (outline.colour.empty()) outline.colour = part.colour;
    for (const std::vector<Point2>& loop : outline_of(seen, part.triangles)) {
      outline.points.insert(outline.points.end(), loop.begin(), loop.end());
      outline.ends.push_back(outline.points.size());
    }
    if (!outline.points.empty()) out.push_back(std::move(outline));
  }
  for (Patch& patch : patches_of(shape)) {
    const Vec3 normal = placed * patch.normal - placed.position;
    if (dot(normal, view.look) > 0) continue;  // on the far side
    Primitive area = like;
    for (Vec3& p : patch.points) area.points.push_back(view(p = placed * p));
    area.kind = Primitive::Kind::area, area.radius = patch.radius, area.depth = mean_depth(view, patch.points);
    out.push_back(std::move(area));
  }
}

bool is_farther(const Primitive& a, const Primitive& b) { return a.depth > b.depth; }

/// Draws one instant.
class FrameBuilder {
 public:
  FrameBuilder(const Recording& run, const RecordedFrame& frame, const View& view)
      : run_(run), frame_(frame), view_(view), phase_(run.phase_at(frame.time)) {
    out_.time = frame.time;
  }

  SceneFrame build() {
    for (std::size_t b = 0; b < run_.bodies.size(); ++b) add_body(b);
    for (const RecordedSpring& spring : run_.springs)
      if (frame_.time < spring.until) add_spring(spring);
    for (const int i : phase_.loops) add_loop(run_.loops[static_cast<std::size_t>(i)]);
    for (std::size_t m = 0; m < run_.mechanisms.size(); ++m) add_end(static_cast<int>(m));
    if (has_area_) std::stable_sort(out_.primitives.begin(), out_.primitives.end(), is_farther);
    return std::move(out_);
  }

 private:
  void add(Primitive::Kind kind, std::size_t b, const std::vector<Vec3>& points, const std::string& colour = {}) {
    Primitive primitive{kind, {}, 0, phase_.mechanism[b], mean_depth(view_, points), colour};
    for (const Vec3& p : points) primitive.points.push_back(view_(p));
    out_.primitives.push_back(std::move(primitive));
  }

  void add_body(std::size_t b) {
    const RecordedBody& body = run_.bodies[b];
    const Pose& pose = frame_.poses[b];
    const std::size_t before = out_.primitives.size();
    for_each_shape(run_, body, [&](const Shape& shape, std::span<const MeshPart> parts) {
      const Primitive like{.mechanism = phase_.mechanism[b], .colour = shape.colour};
      append_shape(shape, parts, pose, view_, like, out_.primitives);
    });
    const bool shaped = out_.primitives.size() > before;
    has_area_ = has_area_ || shaped;
    const auto is_mesh = [](const Primitive& p) { return p.kind == Primitive::Kind::outline; };
    const bool has_mesh =
        std::any_of(out_.primitives.begin() + static_cast<std::ptrdiff_t>(before), out_.primitives.end(), is_mesh);
    for (const auto& [from, to] : body.extent)
      if (!has_mesh) add(Primitive::Kind::line, b, {pose * from, pose * to});
    if (body.extent.empty() && !shaped) add(Primitive::Kind::dot, b, {pose * body.child_at});
    if (!phase_.joined[b]) return;
    add_joint(b, body.kind, body.parent, body.at, body.child_at);
  }

  Vec3 place(int body, const Vec3& point) const {
    return body < 0 ? point : frame_.poses[static_cast<std::size_t>(body)] * point;
  }

  void add_joint(std::size_t child, const std::string& name, int parent, const Vec3& at, const Vec3& child_at) {
    const Vec3 here = place(static_cast<int>(child), child_at), there = place(parent, at);
    const KindInfo* const kind = find_kind(name);
    if (displaces(kind) && norm(here - there) > 1e-9) add(Primitive::Kind::displacement, child, {there, here});
    if (parent >= 0 && moves(kind)) out_.joints.push_back(view_(here));
  }

  /// One that was made in the run may be away from what is drawn of its bodies: lines from them to it show what it joins.
  void add_loop(const RecordedLoop& loop) {
    const auto child = static_cast<std::size_t>(loop.child);
    add_joint(child, loop.kind, loop.parent, loop.at, loop.child_at);
    if (loop.at_start) return;
    if (loop.parent >= 0) add_reach(static_cast<std::size_t>(loop.parent), loop.at);
    add_reach(child, loop.child_at);
  }

  void add_reach(std::size_t b, const Vec3& point) {
    const RecordedBody& body = run_.bodies[b];
    const Vec3 from = nearest_on(body, point, body.child_at, norm(body.child_at - point));
    if (norm(from - point) > 1e-9)
      add(Primitive::Kind::line, b, {place(static_cast<int>(b), from), place(static_cast<int>(b), point)});
  }

  void add_spring(const RecordedSpring& spring) {
    const auto body = static_cast<std::size_t>(std::max(spring.from, spring.to));
    add(Primitive::Kind::spring, body,
        {spring_end(frame_, spring.from, spring.from_point), spring_end(frame_, spring.to, spring.to_point)}, spring_colour);
  }

  /// Adds the end of a mechanism's drawing, for its label.
  void add_end(int mechanism) {
    const auto member = std::find(phase_.mechanism.begin(), phase_.mechanism.end(), mechanism);
    if (member == phase_.mechanism.end()) return;
    const auto first = static_cast<std::size_t>(member - phase_.mechanism.begin());
    const Point2 root = view_(frame_.poses[first] * run_.bodies[first].child_at);
    Point2 end = root;
    for (const Primitive& p : out_.primitives)
      if (p.mechanism == mechanism && p.kind != Primitive::Kind::spring)
        for (const Point2& at : p.points)
          if (distance(at, root) > distance(end, root)) end = at;
    out_.roots.push_back(root);
    out_.ends.push_back(end);
  }

  const Recording& run_;
  const RecordedFrame& frame_;
  const View& view_;
  const Phase& phase_;
  SceneFrame out_;
  bool has_area_ = false;
};

/// Median length of all lines of the first frame, which determines the thickness of links.
double median_length(const SceneFrame& frame) {
  std::vector<double> lengths;
  for (const Primitive& p : frame.primitives)
    if (p.kind == Primitive::Kind::line) lengths.push_back(distance(p.points.front(), p.points.back()));
  if (lengths.empty()) return 0;
  std::nth_element(lengths.begin(), lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2), lengths.end());
  return lengths[lengths.size() / 2];
}

void add_ground(const Recording& run, Scene& scene) {
  for (const auto& [shape, mesh] : run.ground)
    append_shape(shape, {&mesh, mesh.points.empty() ? 0u : 1u}, {}, scene.view, {.mechanism = -1, .colour = ground_colour},
                 scene.ground);
  std::stable_sort(scene.ground.begin(), scene.ground.end(), is_farther);
  for (const Primitive& p : scene.ground)
    for (const Point2& at : p.points) scene.bounds.add(at, p.radius);
}

/// Rectangles of the planes around what is drawn; a plane that is far from it is left out.
void add_planes(const Recording& run, Scene& scene) {
  if (run.planes.empty()) return;
  const std::vector<Vec3> points = drawn_points(run);
  for (const RecordedPlane& plane : run.planes) {
    const Vec3 n = normalized(plane.normal);
    Vec3 across[2];
    contact::perpendiculars(n, across);
    const auto& [a, b] = across;
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL}, nearest = HUGE_VAL;
    for (const Vec3& p : points) {
      nearest = std::min(nearest, std::abs(dot(n, p - plane.point)));
      const double along[2] = {dot(a, p - plane.point), dot(b, p - plane.point)};
      for (int k = 0; k < 2; ++k) low[k] = std::min(low[k], along[k]), high[k] = std::max(high[k], along[k]);
    }
    const double margin = 0.1 * std::max(high[0] - low[0], high[1] - low[1]);
    if (!(nearest < scene.bounds.width() + scene.bounds.height())) continue;
    std::vector<Point2> corners;
    for (const auto& [x, y] : {std::pair{low[0] - margin, low[1] - margin},
                               {high[0] + margin, low[1] - margin},
                               {high[0] + margin, high[1] + margin},
                               {low[0] - margin, high[1] + margin}})
      corners.push_back(scene.view(plane.point + x * a + y * b));
    for (const Point2& corner : corners) scene.bounds.add(corner);
    scene.planes.push_back(std::move(corners));
  }
}

}  // namespace

void Box2::add(const Point2& p, double radius) {
  low = {std::min(low.x, p.x - radius), std::min(low.y, p.y - radius)};
  high = {std::max(high.x, p.x + radius), std::max(high.y, p.y + radius)};
}

std::vector<Vec3> drawn_points(const Recording& run) {
  std::vector<Vec3> points;
  for (const RecordedFrame& frame : run.frames)
    for (std::size_t b = 0; b < run.bodies.size(); ++b) {
      points.push_back(frame.poses[b].position);
      for (const auto& [from, to] : run.bodies[b].extent) points.push_back(frame.poses[b] * to);
      for_each_shape(run, run.bodies[b], [&](const Shape& shape, std::span<const MeshPart> parts) {
        for (const Patch& patch : patches_of(shape))
          for (const Vec3& p : patch.points) points.push_back(frame.poses[b] * (shape.at * p));
        for (const MeshPart& part : parts)
          for (const Vec3& p : part.points) points.push_back(frame.poses[b] * (shape.at * scaled(shape, p)));
      });
    }
  for (const RecordedFrame& frame : run.frames)
    for (const RecordedSpring& spring : run.springs) {
      points.push_back(spring_end(frame, spring.from, spring.from_point));
      points.push_back(spring_end(frame, spring.to, spring.to_point));
    }
  return points;
}

Scene build_scene(const Recording& run, const View& view) {
  Scene scene;
  scene.view = view;
  for (const RecordedFrame& frame : run.frames) scene.frames.push_back(FrameBuilder(run, frame, view).build());
  for (const SceneFrame& frame : scene.frames)
    for (const Primitive& p : frame.primitives) {
      for (const Point2& at : p.points) scene.bounds.add(at, p.radius);
      scene.has_areas = scene.has_areas || p.kind == Primitive::Kind::area || p.kind == Primitive::Kind::outline;
    }
  for (std::size_t b = 0; b < run.bodies.size(); ++b) {
    const RecordedBody& body = run.bodies[b];
    if (body.parent >= 0 || (find_kind(body.kind) != nullptr && find_kind(body.kind)->nv == 6) || body.kind.empty()) continue;
    scene.anchors.push_back(view(body.at));
    scene.bounds.add(scene.anchors.back());
  }
  for (const RecordedLoop& loop : run.loops) {
    if (loop.parent >= 0) continue;
    scene.anchors.push_back(view(loop.at));
    scene.bounds.add(scene.anchors.back());
  }
  add_ground(run, scene);
  add_planes(run, scene);
  for (const RecordedEvent& event : run.events) {
    if (event.name == "stop") {  // joints bounce on their stops many times: these impacts are counted, not listed
      scene.impacts += event.impacts;
      continue;
    }
    if (event.contact) {
      scene.contacts += event.name.rfind("impact", 0) == 0 ? 1 : 0;
      continue;
    }
    SceneEvent shown{event.time, {}, {}};
    for (const std::string& action : event.actions) shown.text += (shown.text.empty() ? "" : ", ") + action;
    const auto mark = [&](int body, const Vec3& point) {
      if (event.frame.poses.empty()) return;
      shown.places.push_back(view(event.frame.poses[static_cast<std::size_t>(body)] * point));
      scene.bounds.add(shown.places.back());
    };
    for (const int b : event.broken) mark(b, run.bodies[static_cast<std::size_t>(b)].child_at);
    for (const int i : event.opened)
      mark(run.loops[static_cast<std::size_t>(i)].child, run.loops[static_cast<std::size_t>(i)].child_at);
    for (const int s : event.broken_springs) {
      if (event.frame.poses.empty()) break;
      const RecordedSpring& spring = run.springs[static_cast<std::size_t>(s)];
      const Vec3 from = spring_end(event.frame, spring.from, spring.from_point),
                 to = spring_end(event.frame, spring.to, spring.to_point);
      shown.places.push_back(view(0.5 * (from + to)));
      scene.bounds.add(shown.places.back());
    }
    scene.events.push_back(std::move(shown));
  }
  if (!scene.frames.empty()) scene.typical_length = median_length(scene.frames.front());
  return scene;
}

}  // namespace momentree::io
