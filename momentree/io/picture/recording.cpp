#include <momentree/io/picture/recording.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include <momentree/base/error.hpp>
#include <momentree/io/json_document.hpp>
#include <momentree/io/line_reader.hpp>
#include <momentree/io/picture/body_table.hpp>
#include <momentree/io/picture/topology_history.hpp>
#include <momentree/io/text_file.hpp>

namespace momentree::io {
namespace {

constexpr const char* damaged = "the file was truncated or modified: run again, or remove it";

std::optional<JsonDocument> parse_file(const std::filesystem::path& file) {
  if (!is_there(file)) return std::nullopt;
  try {
    return parse_json(read_text_file(file.string(), Links::refuse), file.string());
  } catch (Error& error) {
    if (error.hint.empty()) error.hint = damaged;
    throw;
  }
}

const JsonNode& member(const JsonDocument& document, const JsonNode& object, const char* key) {
  const JsonNode* found = document.object(object, "the object with `" + std::string(key) + "`").find(key);
  if (!found) document.fail_at(object, "`" + std::string(key) + "` is missing", damaged);
  return *found;
}

std::string text_or_none(const JsonNode& object, const char* key) {
  const JsonNode* found = object.find(key);
  return found ? found->text : "";
}

template <std::size_t Count>
std::array<double, Count> numbers(const JsonDocument& document, const JsonNode& node, const char* what) {
  const std::vector<double> values = document.numbers(node, what);
  if (values.size() != Count)
    document.fail_at(node, std::string(what) + " should have " + std::to_string(Count) + " numbers", damaged);
  std::array<double, Count> all{};
  std::copy(values.begin(), values.end(), all.begin());
  return all;
}

Vec3 vec(const JsonDocument& document, const JsonNode& node, const char* what) {
  const auto [x, y, z] = numbers<3>(document, node, what);
  return {x, y, z};
}

Pose pose(const JsonDocument& document, const JsonNode& node) {
  const auto [w, x, y, z] = numbers<4>(document, member(document, node, "quat"), "`quat`");
  return {vec(document, member(document, node, "xyz"), "`xyz`"), Quat{w, x, y, z}};
}

Shape read_shape(const JsonDocument& document, const JsonNode& node) {
  Shape shape;
  const std::string kind = document.string(member(document, node, "kind"), "`kind`");
  if (kind == "box") shape.kind = Shape::Kind::box, shape.size = vec(document, member(document, node, "size"), "`size`");
  if (kind == "sphere") shape.kind = Shape::Kind::sphere;
  if (kind == "cylinder") shape.kind = Shape::Kind::cylinder;
  if (kind == "capsule") shape.kind = Shape::Kind::capsule;
  if (kind == "mesh") shape.kind = Shape::Kind::mesh, shape.mesh = text_or_none(node, "file");
  if (const JsonNode* radius = node.find("radius")) shape.radius = document.number(*radius, "`radius`");
  if (const JsonNode* length = node.find("length")) shape.length = document.number(*length, "`length`");
  shape.colour = text_or_none(node, "colour");
  if (const JsonNode* at = node.find("at")) shape.at = pose(document, *at);
  return shape;
}

using Numbers = std::map<std::string, int>;

int find(const Numbers& numbers, const JsonNode& name) {
  const auto it = name.is(JsonNode::Type::string) ? numbers.find(name.text) : numbers.end();
  return it == numbers.end() ? -1 : it->second;
}

void read_joints(const JsonDocument& document, const JsonNode& joints, const Numbers& numbers, Recording& run) {
  for (const auto& [name, joint] : document.object(joints, "`joints`").members) {
    const int child = find(numbers, member(document, joint, "child"));
    if (child < 0) continue;  // bodies.csv may have fewer bodies than the world
    RecordedBody& body = run.bodies[static_cast<std::size_t>(child)];
    body.joint = name;
    body.kind = document.string(member(document, joint, "kind"), "`kind`");
    body.parent = find(numbers, member(document, joint, "parent"));
    body.at = vec(document, member(document, member(document, joint, "at"), "xyz"), "`xyz`");
    body.child_at = vec(document, member(document, member(document, joint, "child_at"), "xyz"), "`xyz`");
  }
}

/// For each body the name of its mechanism, from a list of mechanisms with their bodies.
void read_mechanisms(const JsonDocument& document, const JsonNode& mechanisms, const Numbers& numbers,
                     std::vector<std::string>& of_body) {
  for (const JsonNode& mechanism : document.array(mechanisms, "`mechanisms`").items)
    for (const JsonNode& name : document.array(member(document, mechanism, "bodies"), "`bodies`").items)
      if (const int b = find(numbers, name); b >= 0)
        of_body[static_cast<std::size_t>(b)] = document.string(member(document, mechanism, "name"), "`name`");
}

/// Without model.json: a line from each body's origin to those of its children.
void guess_extents(Recording& run) {
  for (const RecordedBody& body : run.bodies)
    if (body.parent >= 0) run.bodies[static_cast<std::size_t>(body.parent)].extent.emplace_back(Vec3{}, body.at);
}

void read_model(const JsonDocument& document, const Numbers& numbers, Recording& run, std::vector<std::string>& mechanism_of) {
  const JsonNode& model = document.root;
  run.title = text_or_none(model, "title");
  run.gravity = vec(document, member(document, model, "gravity"), "`gravity`");
  read_joints(document, member(document, model, "joints"), numbers, run);
  read_mechanisms(document, member(document, model, "mechanisms"), numbers, mechanism_of);
  for (const auto& [name, body] : document.object(member(document, model, "bodies"), "`bodies`").members) {
    const auto known = numbers.find(name);
    if (known == numbers.end()) continue;
    RecordedBody& recorded = run.bodies[static_cast<std::size_t>(known->second)];
    for (const JsonNode& segment : document.array(member(document, body, "extent"), "`extent`").items) {
      if (document.array(segment, "a segment").items.size() != 2) document.fail_at(segment, "a segment has two ends", damaged);
      recorded.extent.emplace_back(vec(document, segment.items[0], "an end"), vec(document, segment.items[1], "an end"));
    }
    if (const JsonNode* shape = body.find("shape"); shape && !shape->is(JsonNode::Type::null))
      recorded.shape = read_shape(document, *shape);
    if (const JsonNode* more = body.find("more_shapes"))
      for (const JsonNode& shape : document.array(*more, "`more_shapes`").items)
        recorded.shape.more.push_back(read_shape(document, shape));
  }
}

std::vector<std::string> texts(const JsonDocument& document, const JsonNode& list) {
  std::vector<std::string> all;
  for (const JsonNode& item : document.array(list, "a list of names").items) all.push_back(item.text);
  return all;
}

void read_events(const std::filesystem::path& file, const std::vector<std::string>& mechanism_of, Recording& run) {
  TopologyHistory history(run, mechanism_of);
  for_each_event(file, [&](const JsonDocument& document, const std::string&) {
    RecordedEvent event;
    event.time = document.number(member(document, document.root, "time"), "`time`");
    event.name = text_or_none(document.root, "event");
    event.actions = texts(document, member(document, document.root, "actions"));
    history.add(document, event);
    run.events.push_back(std::move(event));
  });
}

}  // namespace

void for_each_event(const std::filesystem::path& file,
                    const std::function<void(const JsonDocument& document, const std::string& line)>& use) {
  if (!is_there(file)) return;
  LineReader in(file);
  for (std::string line; in.next(line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    JsonDocument document;
    try {
      document = parse_json(line, file.string() + ':' + std::to_string(in.number()));
    } catch (const Error&) {
      if (!in.is_whole()) break;  // an interrupted run was still writing this line
      throw_error({"the line is not JSON", file.string() + ':' + std::to_string(in.number()), damaged});
    }
    use(document, line);
  }
}

Recording read_recording(const std::filesystem::path& directory, double every) {
  if (!std::filesystem::is_directory(directory))
    throw_error({"there is no such directory", directory.string(), "run the scenario first: momentree run SCENARIO --out DIR"});
  const BodyTable table(directory / "bodies.csv");
  Recording run;
  Numbers numbers;
  std::vector<std::string> mechanism_of;
  for (const std::string& name : table.bodies()) {
    numbers.emplace(name, static_cast<int>(run.bodies.size()));
    run.bodies.push_back({});
    run.bodies.back().name = run.bodies.back().joint = name;
    mechanism_of.push_back(name.substr(0, name.find('/')));
  }

  const std::optional<JsonDocument> model = parse_file(directory / "model.json");
  const std::optional<JsonDocument> final_state = parse_file(directory / "final.json");
  if (model)
    read_model(*model, numbers, run, mechanism_of);
  else if (final_state)
    read_joints(*final_state, member(*final_state, final_state->root, "joints"), numbers, run), guess_extents(run);
  if (run.title.empty()) run.title = std::filesystem::absolute(directory).lexically_normal().filename().string();
  read_events(directory / "events.jsonl", mechanism_of, run);
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
