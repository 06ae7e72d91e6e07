#include <momentree/export/foxglove_schemas.hpp>

#include <initializer_list>
#include <utility>

namespace momentree::io::foxglove {

namespace {

using Members = std::initializer_list<std::pair<const char*, std::string>>;

std::string object_of(const char* title, const Members& members) {
  std::string text = R"({"type": "object")";
  if (*title != '\0') text += R"(, "title": ")" + std::string(title) + '"';
  text += R"(, "properties": {)";
  bool first = true;
  for (const auto& [name, schema] : members) {
    text += (first ? "\"" : ", \"") + std::string(name) + "\": " + schema;
    first = false;
  }
  return text + "}}";
}

std::string list_of(const std::string& items) { return R"({"type": "array", "items": )" + items + '}'; }

std::string text() { return R"({"type": "string"})"; }
std::string truth() { return R"({"type": "boolean"})"; }
std::string count() { return R"({"type": "integer", "minimum": 0})"; }
std::string real(const char* about = "") {
  return *about == '\0' ? R"({"type": "number"})" : R"({"type": "number", "description": ")" + std::string(about) + "\"}";
}
std::string reals(const char* about) {
  return R"({"type": "array", "items": {"type": "number"}, "description": ")" + std::string(about) + "\"}";
}
std::string one_of(std::initializer_list<const char*> names) {
  std::string text = R"({"oneOf": [)";
  int value = 0;
  for (const char* name : names)
    text += std::string(value > 0 ? ", " : "") + R"({"title": ")" + name + R"(", "const": )" + std::to_string(value) + '}',
        ++value;
  return text + "]}";
}
std::string nanoseconds() { return R"({"type": "integer", "minimum": 0, "maximum": 999999999})"; }
std::string time() { return object_of("time", {{"sec", count()}, {"nsec", nanoseconds()}}); }
std::string duration() { return object_of("duration", {{"sec", R"({"type": "integer"})"}, {"nsec", nanoseconds()}}); }
std::string vector(const char* title = "foxglove.Vector3") {
  return object_of(title, {{"x", real()}, {"y", real()}, {"z", real()}});
}
std::string quaternion() {
  return object_of("foxglove.Quaternion", {{"x", real()}, {"y", real()}, {"z", real()}, {"w", real()}});
}
std::string pose() { return object_of("foxglove.Pose", {{"position", vector()}, {"orientation", quaternion()}}); }
std::string colour() { return object_of("foxglove.Color", {{"r", real()}, {"g", real()}, {"b", real()}, {"a", real()}}); }
std::string points() { return list_of(vector("foxglove.Point3")); }
std::string indices() { return list_of(count()); }

std::string schema(const std::string& name, const std::string& description, std::string object) {
  return R"({"$schema": "https://json-schema.org/draft/2020-12/schema", "description": ")" + description + R"(", "title": ")" +
         name + "\", " + object.substr(1);
}

}  // namespace

std::string frame_transforms_schema() {
  const std::string transform = object_of("foxglove.FrameTransform", {{"timestamp", time()},
                                                                      {"parent_frame_id", text()},
                                                                      {"child_frame_id", text()},
                                                                      {"translation", vector()},
                                                                      {"rotation", quaternion()}});
  return schema("foxglove.FrameTransforms", "An array of FrameTransform messages",
                object_of("", {{"transforms", list_of(transform)}}));
}

std::string scene_update_schema() {
  const std::string deletion = object_of("foxglove.SceneEntityDeletion",
                                         {{"timestamp", time()}, {"type", one_of({"MATCHING_ID", "ALL"})}, {"id", text()}});
  const std::string pair = object_of("foxglove.KeyValuePair", {{"key", text()}, {"value", text()}});
  const std::string arrow = object_of("foxglove.ArrowPrimitive", {{"pose", pose()},
                                                                  {"shaft_length", real()},
                                                                  {"shaft_diameter", real()},
                                                                  {"head_length", real()},
                                                                  {"head_diameter", real()},
                                                                  {"color", colour()}});
  const std::string cube = object_of("foxglove.CubePrimitive", {{"pose", pose()}, {"size", vector()}, {"color", colour()}});
  const std::string sphere = object_of("foxglove.SpherePrimitive", {{"pose", pose()}, {"size", vector()}, {"color", colour()}});
  const std::string cylinder =
      object_of("foxglove.CylinderPrimitive",
                {{"pose", pose()}, {"size", vector()}, {"bottom_scale", real()}, {"top_scale", real()}, {"color", colour()}});
  const std::string line = object_of("foxglove.LinePrimitive", {{"type", one_of({"LINE_STRIP", "LINE_LOOP", "LINE_LIST"})},
                                                                {"pose", pose()},
                                                                {"thickness", real()},
                                                                {"scale_invariant", truth()},
                                                                {"points", points()},
                                                                {"color", colour()},
                                                                {"colors", list_of(colour())},
                                                                {"indices", indices()}});
  const std::string triangles = object_of(
      "foxglove.TriangleListPrimitive",
      {{"pose", pose()}, {"points", points()}, {"color", colour()}, {"colors", list_of(colour())}, {"indices", indices()}});
  const std::string words = object_of("foxglove.TextPrimitive", {{"pose", pose()},
                                                                 {"billboard", truth()},
                                                                 {"font_size", real()},
                                                                 {"scale_invariant", truth()},
                                                                 {"color", colour()},
                                                                 {"text", text()}});
  const std::string model =
      object_of("foxglove.ModelPrimitive", {{"pose", pose()},
                                            {"scale", vector()},
                                            {"color", colour()},
                                            {"override_color", truth()},
                                            {"url", text()},
                                            {"media_type", text()},
                                            {"data", R"({"type": "string", "contentEncoding": "base64"})"}});
  const std::string entity = object_of("foxglove.SceneEntity", {{"timestamp", time()},
                                                                {"frame_id", text()},
                                                                {"id", text()},
                                                                {"lifetime", duration()},
                                                                {"frame_locked", truth()},
                                                                {"metadata", list_of(pair)},
                                                                {"arrows", list_of(arrow)},
                                                                {"cubes", list_of(cube)},
                                                                {"spheres", list_of(sphere)},
                                                                {"cylinders", list_of(cylinder)},
                                                                {"lines", list_of(line)},
                                                                {"triangles", list_of(triangles)},
                                                                {"texts", list_of(words)},
                                                                {"models", list_of(model)}});
  return schema("foxglove.SceneUpdate", "An update to the entities displayed in a 3D scene",
                object_of("", {{"deletions", list_of(deletion)}, {"entities", list_of(entity)}}));
}

std::string log_schema() {
  return schema("foxglove.Log", "A log message",
                object_of("", {{"timestamp", time()},
                               {"level", one_of({"UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"})},
                               {"message", text()},
                               {"name", text()},
                               {"file", text()},
                               {"line", count()}}));
}

std::string joint_states_schema() {
  const std::string joint =
      object_of("", {{"name", text()},
                     {"q", reals("coordinates (rad, m, quaternions w, x, y, z)")},
                     {"v", reals("velocities (rad/s, m/s)")},
                     {"p", reals("canonical momenta (N m s, N s)")},
                     {"force", reals("of the parent on the child (N), in the child's axes")},
                     {"torque", reals("of the parent on the child (N m), about the joint's frame there, in the child's axes")}});
  return schema("momentree.JointStates", "The joints that exist at this time",
                object_of("", {{"timestamp", time()}, {"joints", list_of(joint)}}));
}

std::string spring_states_schema() {
  const std::string spring = object_of(
      "", {{"name", text()}, {"length", real("m")}, {"rate", real("m/s")}, {"tension", real("N; negative: it pushes")}});
  return schema("momentree.SpringStates", "The springs that are not broken at this time",
                object_of("", {{"timestamp", time()}, {"springs", list_of(spring)}}));
}

std::string energy_schema() {
  return schema("momentree.Energy", "Energies (J) and momenta of the world, about its origin",
                object_of("", {{"timestamp", time()},
                               {"kinetic", real("J")},
                               {"gravity", real("J")},
                               {"elastic", real("J, in springs and soft stops")},
                               {"dissipated", real("J, since the start")},
                               {"lost", real("J, in impacts since the start")},
                               {"released", real("J, since the start")},
                               {"work", real("J, supplied since the start")},
                               {"error", real("J, of the balance")},
                               {"linear", vector("linear momentum (N s)")},
                               {"angular", vector("angular momentum (N m s)")}}));
}

}  // namespace momentree::io::foxglove
