#include <momentree/export/scene_messages.hpp>

#include <algorithm>
#include <initializer_list>

#include <momentree/text/colour.hpp>

namespace momentree::io::foxglove {

namespace {

void write_vector(JsonWriter& json, const char* key, const Vec3& v) {
  json.key(key).begin_object().member("x", v.x).member("y", v.y).member("z", v.z).end_object();
}

void write_quaternion(JsonWriter& json, const char* key, const Quat& q) {
  json.key(key).begin_object().member("x", q.x).member("y", q.y).member("z", q.z).member("w", q.w).end_object();
}

void write_place(JsonWriter& json, const Pose& pose) {
  json.key("pose").begin_object();
  write_vector(json, "position", pose.position);
  write_quaternion(json, "orientation", pose.rotation);
  json.end_object();
}

void write_colour(JsonWriter& json, const std::string& colour) {
  const Rgb rgb = rgb_of(colour);
  json.key("color").begin_object().member("r", rgb.r).member("g", rgb.g).member("b", rgb.b).member("a", 1.0).end_object();
}

void write_empty(JsonWriter& json, std::initializer_list<const char*> keys) {
  for (const char* key : keys) json.key(key).begin_array().end_array();
}

/// An entity up to its lists of primitives.
void begin_entity(JsonWriter& json, std::uint64_t time, const std::string& frame, const std::string& id) {
  json.begin_object();
  write_time(json, "timestamp", time);
  json.member("frame_id", frame).member("id", id);
  write_time(json, "lifetime", 0);
  json.member("frame_locked", true);
}

/// A list of those solids that are of this kind.
template <class Write>
void write_solids(JsonWriter& json, const char* key, const std::vector<const Solid*>& solids,
                  std::initializer_list<Solid::Kind> kinds, const Write& write) {
  json.key(key).begin_array();
  for (const Solid* solid : solids)
    if (std::find(kinds.begin(), kinds.end(), solid->kind) != kinds.end()) write(*solid);
  json.end_array();
}

class EntityWriter {
 public:
  EntityWriter(JsonWriter& json, const Drawing& drawing, const std::string& mechanism_colour)
      : json_(json), drawing_(drawing), mechanism_colour_(mechanism_colour) {}

  void write(const std::vector<const Solid*>& solids) {
    using Kind = Solid::Kind;
    write_empty(json_, {"arrows"});
    write_solids(json_, "cubes", solids, {Kind::box}, [&](const Solid& s) { sized(s, s.at, s.size); });
    write_solids(json_, "spheres", solids, {Kind::ellipsoid, Kind::capsule}, [&](const Solid& s) {
      if (s.kind == Kind::ellipsoid) return sized(s, s.at, s.size);
      for (const double side : {-0.5, 0.5})
        sized(s, {s.at * Vec3{0, 0, side * s.size.z}, s.at.rotation}, {s.size.x, s.size.x, s.size.x});
    });
    write_solids(json_, "cylinders", solids, {Kind::cylinder, Kind::capsule}, [&](const Solid& s) {
      begin(s.at);
      write_vector(json_, "size", s.size);
      json_.member("bottom_scale", 1.0).member("top_scale", 1.0);
      end(s);
    });
    write_empty(json_, {"lines"});
    write_solids(json_, "triangles", solids, {Kind::mesh}, [&](const Solid& s) { triangles(s); });
    write_empty(json_, {"texts", "models"});
  }

 private:
  void begin(const Pose& at) {
    json_.begin_object();
    write_place(json_, at);
  }
  void end(const Solid& solid) {
    write_colour(json_, solid.colour.empty() ? mechanism_colour_ : solid.colour);
    json_.end_object();
  }
  void sized(const Solid& solid, const Pose& at, const Vec3& size) {
    begin(at);
    write_vector(json_, "size", size);
    end(solid);
  }
  void triangles(const Solid& solid) {
    const MeshPart& part = drawing_.run.mesh_parts[static_cast<std::size_t>(solid.mesh)];
    const Vec3& s = solid.size;
    begin(solid.at);
    json_.key("points").begin_array();
    for (const Vec3& p : part.points)
      json_.begin_object().member("x", s.x * p.x).member("y", s.y * p.y).member("z", s.z * p.z).end_object();
    json_.end_array();
    write_empty(json_, {"colors"});
    json_.key("indices").begin_array();
    for (const auto& triangle : part.triangles)
      for (const std::uint32_t corner : triangle) json_.value(static_cast<long>(corner));
    json_.end_array();
    end(solid);
  }

  JsonWriter& json_;
  const Drawing& drawing_;
  const std::string& mechanism_colour_;
};

}  // namespace

void write_time(JsonWriter& json, const char* key, std::uint64_t time) {
  json.key(key).begin_object().member("sec", static_cast<long>(time / 1'000'000'000));
  json.member("nsec", static_cast<long>(time % 1'000'000'000)).end_object();
}

std::string frame_transforms(const Drawing& drawing, std::size_t row, std::uint64_t time, const std::string& world) {
  std::string text;
  JsonWriter json(text);
  json.begin_object().key("transforms").begin_array();
  for (std::size_t b = 0; b < drawing.run.bodies.size(); ++b) {
    const double* const p = drawing.pose(row, b);
    json.begin_object();
    write_time(json, "timestamp", time);
    json.member("parent_frame_id", world).member("child_frame_id", drawing.run.bodies[b].name);
    write_vector(json, "translation", {p[0], p[1], p[2]});
    write_quaternion(json, "rotation", {p[3], p[4], p[5], p[6]});
    json.end_object();
  }
  json.end_array().end_object();
  return text;
}

std::string scene(const Drawing& drawing, Solids which, const Colouring& colouring, std::uint64_t time) {
  std::string text;
  JsonWriter json(text);
  json.begin_object();
  write_empty(json, {"deletions"});
  json.key("entities").begin_array();
  bool any = false;
  for (std::size_t b = 0; b < drawing.run.bodies.size(); ++b) {
    std::vector<const Solid*> solids;
    for (const Solid& solid : drawing.solids[b])
      if (solid.colour.empty() == (which == Solids::mechanism_colours)) solids.push_back(&solid);
    if (solids.empty()) continue;
    any = true;
    const std::string& name = drawing.run.bodies[b].name;
    const int mechanism = colouring.mechanism[b];
    begin_entity(json, time, name, name);
    json.key("metadata").begin_array();
    if (which == Solids::mechanism_colours)
      json.begin_object()
          .member("key", "mechanism")
          .member("value", drawing.run.mechanisms[static_cast<std::size_t>(mechanism)])
          .end_object();
    json.end_array();
    const std::string colour = Drawing::colour_of(mechanism);
    EntityWriter(json, drawing, colour).write(solids);
    json.end_object();
  }
  json.end_array().end_object();
  return any ? text : "";
}

std::string bars(const Drawing& drawing, std::size_t row, std::uint64_t time, const std::string& world) {
  std::string text;
  JsonWriter json(text);
  json.begin_object();
  write_empty(json, {"deletions"});
  json.key("entities").begin_array();
  begin_entity(json, time, world, "bars");
  write_empty(json, {"metadata", "arrows", "cubes", "spheres", "cylinders"});
  json.key("lines").begin_array();
  for (const Bar& bar : drawing.bars) {
    if (drawing.times[row] < bar.begin || drawing.times[row] >= bar.end) continue;
    json.begin_object().member("type", 0);
    write_place(json, {});
    json.member("thickness", 2 * bar.radius).member("scale_invariant", false).key("points").begin_array();
    for (const Vec3& p : {drawing.place(row, bar.from, bar.from_point), drawing.place(row, bar.to, bar.to_point)})
      json.begin_object().member("x", p.x).member("y", p.y).member("z", p.z).end_object();
    json.end_array();
    write_colour(json, bar.colour);
    write_empty(json, {"colors", "indices"});
    json.end_object();
  }
  json.end_array();
  write_empty(json, {"triangles", "texts", "models"});
  json.end_object().end_array().end_object();
  return text;
}

std::string log(Level level, std::string_view name, std::string_view message, std::uint64_t time) {
  std::string text;
  JsonWriter json(text);
  json.begin_object();
  write_time(json, "timestamp", time);
  json.member("level", static_cast<int>(level)).member("message", message).member("name", name);
  json.member("file", "").member("line", 0).end_object();
  return text;
}

}  // namespace momentree::io::foxglove
