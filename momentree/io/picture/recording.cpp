#include <momentree/io/picture/recording.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <optional>

#include <nlohmann/json.hpp>

#include <momentree/base/error.hpp>
#include <momentree/io/picture/body_table.hpp>
#include <momentree/io/picture/phases.hpp>

namespace momentree::io {
namespace {

using Json = nlohmann::json;

std::optional<Json> parse_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  try {
    return Json::parse(in);
  } catch (const Json::exception& error) {  // broken syntax, or a number beyond all bounds
    fail({"it is not JSON: " + std::string(error.what()), file.string(), "the file was cut or changed: run again, or remove it"});
  }
}

/// Runs `body`; what the JSON lacks becomes an Error that names the file.
void reading(const std::string& where, const std::function<void()>& body) {
  try {
    body();
  } catch (const Json::exception& error) {
    fail({"it does not hold what was expected: " + std::string(error.what()), where, "it must be as `momentree run` wrote it"});
  }
}

Vec3 vec(const Json& j) { return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()}; }
Quat quat(const Json& j) { return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>(), j.at(3).get<double>()}; }
Pose pose(const Json& j) { return {vec(j.at("xyz")), quat(j.at("quat"))}; }

Shape read_shape(const Json& j) {
  Shape shape;
  const std::string kind = j.at("kind");
  if (kind == "box") shape.kind = Shape::Kind::box, shape.size = vec(j.at("size"));
  if (kind == "sphere") shape.kind = Shape::Kind::sphere;
  if (kind == "cylinder") shape.kind = Shape::Kind::cylinder;
  if (kind == "capsule") shape.kind = Shape::Kind::capsule;
  if (kind == "mesh") shape.kind = Shape::Kind::mesh, shape.mesh = j.value("file", "");
  shape.radius = j.value("radius", 0.0);
  shape.length = j.value("length", 0.0);
  shape.colour = j.value("colour", "");
  if (j.contains("at")) shape.at = pose(j.at("at"));
  return shape;
}

using Numbers = std::map<std::string, int>;

int find(const Numbers& numbers, const Json& name) {
  if (!name.is_string()) return -1;
  const auto it = numbers.find(name.get<std::string>());
  return it == numbers.end() ? -1 : it->second;
}

void read_joints(const Json& joints, const Numbers& numbers, Recording& run) {
  for (const auto& [name, joint] : joints.items()) {
    const int child = find(numbers, joint.at("child"));
    if (child < 0) continue;  // bodies.csv may hold fewer bodies than the world
    RecordedBody& body = run.bodies[static_cast<std::size_t>(child)];
    body.joint = name;
    body.kind = joint.at("kind").get<std::string>();
    body.parent = find(numbers, joint.at("parent"));
    body.at = vec(joint.at("at").at("xyz"));
    body.child_at = vec(joint.at("child_at").at("xyz"));
  }
}

/// By body the name of its mechanism, from a list of mechanisms with their bodies.
void read_mechanisms(const Json& mechanisms, const Numbers& numbers, std::vector<std::string>& of_body) {
  for (const Json& mechanism : mechanisms)
    for (const Json& name : mechanism.at("bodies"))
      if (const int b = find(numbers, name); b >= 0)
        of_body[static_cast<std::size_t>(b)] = mechanism.at("name").get<std::string>();
}

/// Without model.json: a line from each body's origin to those of its children.
void guess_extents(Recording& run) {
  for (const RecordedBody& body : run.bodies)
    if (body.parent >= 0) run.bodies[static_cast<std::size_t>(body.parent)].extent.emplace_back(Vec3{}, body.at);
}

void read_model(const Json& model, const Numbers& numbers, Recording& run, std::vector<std::string>& mechanism_of) {
  run.title = model.value("title", "");
  run.gravity = vec(model.at("gravity"));
  read_joints(model.at("joints"), numbers, run);
  read_mechanisms(model.at("mechanisms"), numbers, mechanism_of);
  for (const auto& [name, body] : model.at("bodies").items()) {
    const int b = find(numbers, name);
    if (b < 0) continue;
    RecordedBody& recorded = run.bodies[static_cast<std::size_t>(b)];
    for (const Json& segment : body.at("extent")) recorded.extent.emplace_back(vec(segment.at(0)), vec(segment.at(1)));
    if (body.contains("shape") && !body.at("shape").is_null()) recorded.shape = read_shape(body.at("shape"));
    for (const Json& more : body.value("more_shapes", Json::array())) recorded.shape.more.push_back(read_shape(more));
  }
}

void read_events(const std::filesystem::path& file, Recording& run) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  for (int n = 1; std::getline(in, line); ++n) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (in.eof() && !Json::accept(line)) break;  // an interrupted run was still writing this line
    const std::string where = file.string() + ":" + std::to_string(n);
    if (!Json::accept(line)) fail({"the line is not JSON", where, "the file was cut or changed: run again, or remove it"});
    reading(where, [&] {
      const Json json = Json::parse(line);
      RecordedEvent event;
      event.time = json.at("time").get<double>();
      event.name = json.value("event", "");
      for (const Json& action : json.at("actions"))
        event.actions.push_back(action.is_string() ? action.get<std::string>() : action.dump());
      if (json.contains("mechanisms")) {
        event.before = json.at("mechanisms").at("before").get<std::vector<std::string>>();
        event.after = json.at("mechanisms").at("after").get<std::vector<std::string>>();
      }
      run.events.push_back(std::move(event));
    });
  }
}

}  // namespace

Recording read_story(const std::filesystem::path& directory, const std::vector<std::string>& bodies) {
  Recording run;
  Numbers numbers;
  std::vector<std::string> mechanism_of;
  for (const std::string& name : bodies) {
    numbers.emplace(name, static_cast<int>(run.bodies.size()));
    run.bodies.push_back({});
    run.bodies.back().name = run.bodies.back().joint = name;
    mechanism_of.push_back(name.substr(0, name.find('/')));
  }

  const std::optional<Json> model = parse_file(directory / "model.json");
  const std::optional<Json> final_state = parse_file(directory / "final.json");
  if (model)
    reading((directory / "model.json").string(), [&] { read_model(*model, numbers, run, mechanism_of); });
  else if (final_state)
    reading((directory / "final.json").string(),
            [&] { read_joints(final_state->at("joints"), numbers, run), guess_extents(run); });
  if (run.title.empty()) run.title = std::filesystem::absolute(directory).lexically_normal().filename().string();
  read_events(directory / "events.jsonl", run);
  find_phases(run, mechanism_of);
  if (final_state) {
    reading((directory / "final.json").string(), [&] {
      std::vector<std::string> at_end = mechanism_of;
      read_mechanisms(final_state->at("mechanisms"), numbers, at_end);
      correct_last_phase(run, at_end);
    });
  }
  return run;
}

Recording read_recording(const std::filesystem::path& directory, double every) {
  if (!std::filesystem::is_directory(directory))
    fail({"there is no such directory", directory.string(), "run the scenario first: momentree run SCENARIO --out DIR"});
  const BodyTable table(directory / "bodies.csv");
  std::vector<std::string> names;
  for (const PoseColumns& column : table.bodies()) names.push_back(column.name);
  Recording run = read_story(directory, names);
  const std::vector<std::size_t> rows = choose_rows(table, every);
  run.every = every;
  run.frames = table.read(rows);
  for (RecordedEvent& event : run.events) {
    const std::size_t row = table.row_near(event.time);
    if (std::abs(table.times()[row] - event.time) < 0.25 * every) event.frame = table.read({row}).front();
  }
  return run;
}

const Phase& Recording::phase_at(double time) const {
  const auto later = std::find_if(phases.begin() + 1, phases.end(),
                                  [&](const Phase& p) { return p.from > time + 1e-9 * std::max(1.0, std::abs(time)); });
  return *(later - 1);
}

}  // namespace momentree::io
