#include <momentree/results/recording/recording.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

#include <momentree/base/error.hpp>
#include <momentree/results/recording/body_table.hpp>
#include <momentree/results/recording/record.hpp>
#include <momentree/results/recording/topology_history.hpp>
#include <momentree/text/files/line_reader.hpp>
#include <momentree/text/files/text_file.hpp>
#include <momentree/text/json.hpp>

namespace momentree::io {
namespace {

std::string text_or_none(const Value& object, const char* key) {
  const Value::Entry* found = object.find(key);
  return found && found->value.string() ? *found->value.string() : "";
}

Shape read_shape(const Value& value, Diagnostics& out) {
  Record record(value, "shape", out);
  Shape shape;
  const std::string kind = record.text("kind");
  contact::each_primitive([&](auto primitive) {
    if (kind != primitive.info.key) return;
    describe(record, primitive);
    shape = Shape::of(primitive);
  });
  if (kind == "mesh") shape.kind = Shape::Kind::mesh, shape.mesh = text_or_none(value, "file");
  if (record.find("scale")) shape.scale = record.vec("scale");
  shape.colour = text_or_none(value, "colour");
  if (const Value* at = record.find("at")) {
    Record pose(*at, "at", out);
    const std::vector<double> q = read_reals(pose["quat"], 4, "quat", out);
    shape.at = {pose.vec("xyz"), q.empty() ? Quat{} : Quat{q[0], q[1], q[2], q[3]}};
  }
  return shape;
}

/// The number of a shape's mesh in meshes.json; −1: none.
int mesh_of(const Value& shape) {
  const Value::Entry* found = shape.find("mesh");
  const std::int64_t* number = found ? found->value.integer() : nullptr;
  return number && *number >= 0 && *number < 1'000'000 ? static_cast<int>(*number) : -1;
}

void read_joints(const Value::Table& joints, const BodyNumbers& numbers, Recording& run, Diagnostics& out) {
  for (const Value::Entry& entry : joints) {
    RecordedLoop joint = read_joint(entry, numbers, out);
    if (joint.child < 0) continue;              // bodies.csv may have fewer bodies than the world
    if (entry.value.find("loop") != nullptr) {  // in addition to the body's inboard joint
      joint.at_start = true;
      run.loops.push_back(std::move(joint));
      continue;
    }
    RecordedBody& body = run.bodies[static_cast<std::size_t>(joint.child)];
    body.joint = joint.name, body.kind = joint.kind, body.parent = joint.parent;
    body.at = joint.at, body.child_at = joint.child_at;
  }
}

/// Without model.json: a line from each body's origin to those of its children, and to joints that close loops.
void guess_extents(Recording& run) {
  const auto reach = [&run](int body, const Vec3& point) {
    if (body >= 0 && norm(point) > 0) run.bodies[static_cast<std::size_t>(body)].extent.emplace_back(Vec3{}, point);
  };
  for (const RecordedBody& body : run.bodies) reach(body.parent, body.at);
  for (const RecordedLoop& loop : run.loops) reach(loop.parent, loop.at), reach(loop.child, loop.child_at);
}

void read_model(const Value& document, const BodyNumbers& numbers, Recording& run, std::vector<std::string>& mechanism_of,
                Diagnostics& out) {
  Record model(document, "the model", out);
  run.title = text_or_none(document, "title");
  run.gravity = model.vec("gravity");
  read_joints(model.table("joints"), numbers, run, out);
  for (const Value& value : model.list("mechanisms")) {
    Record mechanism(value, "mechanism", out);
    for (const Value& name : mechanism.list("bodies"))
      if (const int b = find_body(numbers, name); b >= 0) mechanism_of[static_cast<std::size_t>(b)] = mechanism.text("name");
  }
  for (const Value::Entry& entry : model.table("bodies")) {
    const auto known = numbers.find(entry.key);
    if (known == numbers.end()) continue;
    Record body(entry.value, "body", out);
    RecordedBody& recorded = run.bodies[static_cast<std::size_t>(known->second)];
    for (const Value& segment : body.list("extent")) {
      const Value::Array& ends = read_list(segment, "extent", out);
      if (ends.size() != 2)
        out.error(segment.place, "extent: a segment has two ends", damaged);
      else
        recorded.extent.emplace_back(body.vec(ends[0], "extent"), body.vec(ends[1], "extent"));
    }
    if (const Value* shape = body.find("shape"); shape && !shape->is_null()) {
      recorded.shape = read_shape(*shape, out);
      recorded.meshes.push_back(mesh_of(*shape));
      if (body.find("more_shapes"))
        for (const Value& each : body.list("more_shapes")) {
          recorded.shape.more.push_back(read_shape(each, out));
          recorded.meshes.push_back(mesh_of(each));
        }
    }
    if (body.find("mass")) recorded.mass = body.number("mass");
    if (body.find("com")) recorded.com = body.vec("com");
    if (const Value* inertia = body.find("inertia"))
      if (const std::vector<double> I = read_reals(*inertia, 6, "inertia", out); !I.empty())
        recorded.inertia = Sym3{I[0], I[1], I[2], I[3], I[4], I[5]};
  }
}

void read_ground(const Value& document, Recording& run, Diagnostics& out) {
  Record model(document, "the model", out);
  if (model.find("ground"))
    for (const Value& value : model.list("ground")) {
      GroundShape& ground = run.ground.emplace_back();
      ground.shape = read_shape(value, out);
      Record shape(value, "ground", out);
      if (ground.shape.kind != Shape::Kind::mesh) continue;
      for (const Value& point : shape.list("points")) ground.mesh.points.push_back(shape.vec(point, "points"));
      for (const Value& triangle : shape.list("triangles")) {
        const std::vector<double> corners = read_reals(triangle, 3, "triangles", out);
        auto& [a, b, c] = ground.mesh.triangles.emplace_back();
        for (std::size_t k = 0; k < corners.size(); ++k)
          if (!(corners[k] >= 0 && corners[k] < static_cast<double>(ground.mesh.points.size())))
            out.error(triangle.place, "triangles: there is no point of that number", damaged);
        if (corners.empty() || out.errors() > 0) continue;
        a = static_cast<std::uint32_t>(corners[0]), b = static_cast<std::uint32_t>(corners[1]);
        c = static_cast<std::uint32_t>(corners[2]);
      }
    }
  if (!model.find("planes")) return;
  for (const Value& value : model.list("planes")) {
    Record plane(value, "plane", out);
    run.planes.push_back({plane.vec("point"), plane.vec("normal")});
    if (norm(run.planes.back().normal) > 0) continue;
    out.error(value.place, "normal: it is zero", damaged);
    run.planes.pop_back();
  }
}

void read_springs(const Value& document, const BodyNumbers& numbers, Recording& run, Diagnostics& out) {
  Record model(document, "the model", out);
  if (!model.find("springs")) return;
  for (const Value::Entry& entry : model.table("springs")) {
    Record spring(entry.value, "spring", out);
    RecordedSpring recorded;
    recorded.name = entry.key;
    bool known = true;
    const auto read_end = [&](const char* key, int& body, Vec3& point) {
      Record end(spring[key], key, out);
      const Value& name = end["body"];
      body = find_body(numbers, name);
      known = known && (body >= 0 || (name.string() && *name.string() == "ground"));
      point = end.vec("point");
    };
    read_end("from", recorded.from, recorded.from_point);
    read_end("to", recorded.to, recorded.to_point);
    const Value* const broken = spring.find("broken");
    if (broken != nullptr && broken->boolean() && *broken->boolean()) recorded.until = -HUGE_VAL;
    if (known) run.springs.push_back(std::move(recorded));
  }
}

// Springs that an event broke.
void note_broken_springs(const Value& document, Recording& run, RecordedEvent& event) {
  const Value::Entry* const topology = document.find("topology");
  const Value::Entry* const broken = topology != nullptr ? topology->value.find("broken_springs") : nullptr;
  if (broken == nullptr || !broken->value.array()) return;
  for (const Value& name : *broken->value.array())
    for (std::size_t s = 0; name.string() && s < run.springs.size(); ++s)
      if (run.springs[s].name == *name.string()) {
        run.springs[s].until = std::min(run.springs[s].until, event.time);
        event.broken_springs.push_back(static_cast<int>(s));
      }
}

void read_events(const std::filesystem::path& file, const BodyNumbers& numbers, const std::vector<std::string>& mechanism_of,
                 Recording& run) {
  TopologyHistory history(run, numbers, mechanism_of);
  for_each_event(file, [&](const Value& document, const std::string&, const std::string& where) {
    Diagnostics out(where, "");
    Record record(document, "the event", out);
    RecordedEvent event;
    event.time = record.number("time");
    event.name = text_or_none(document, "event");
    for (const Value& action : record.list("actions")) event.actions.push_back(action.string() ? *action.string() : "");
    history.add(record, event, out);
    note_broken_springs(document, run, event);
    out.throw_first();
    run.events.push_back(std::move(event));
  });
}

}  // namespace

void require_result_folder(const std::filesystem::path& directory) {
  if (!std::filesystem::is_directory(directory))
    throw_error({"there is no such directory", directory.string(), "run the scenario first: momentree run SCENARIO --out DIR"});
}

std::optional<Value> find_document(const std::filesystem::path& file) {
  if (!is_there(file)) return std::nullopt;
  try {
    return parse_json(read_text_file(file.string(), Links::refuse), file.string());
  } catch (const Error& error) {
    throw_error({error.problem, error.where, error.hint.empty() ? damaged : error.hint});
  }
}

void for_each_event(const std::filesystem::path& file,
                    const std::function<void(const Value& document, const std::string& line, const std::string& where)>& use) {
  if (!is_there(file)) return;
  LineReader in(file);
  for (std::string line; in.next(line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string where = file.string() + ':' + std::to_string(in.number());
    Value document;
    try {
      document = parse_json(line, where);
    } catch (const Error&) {
      if (!in.is_whole()) break;  // an interrupted run was still writing this line
      throw_error({"the line is not JSON", where, damaged});
    }
    use(document, line, where);
  }
}

Recording read_world(const std::filesystem::path& directory, const BodyTable& table) {
  Recording run;
  run.folder = directory;
  BodyNumbers numbers;
  std::vector<std::string> mechanism_of;
  for (const std::string& name : table.bodies()) {
    numbers.emplace(name, static_cast<int>(run.bodies.size()));
    run.bodies.push_back({});
    run.bodies.back().name = run.bodies.back().joint = name;
    mechanism_of.push_back(name.substr(0, name.find('/')));
  }

  const std::optional<Value> model = find_document(directory / "model.json"),
                             final_state = find_document(directory / "final.json");
  Diagnostics out((directory / (model ? "model.json" : "final.json")).string(), "");
  if (model)
    read_model(*model, numbers, run, mechanism_of, out), read_springs(*model, numbers, run, out), read_ground(*model, run, out);
  else if (final_state)
    read_joints(Record(*final_state, "the state", out).table("joints"), numbers, run, out), guess_extents(run);
  out.throw_first();
  if (run.title.empty()) run.title = std::filesystem::absolute(directory).lexically_normal().filename().string();
  read_events(directory / "events.jsonl", numbers, mechanism_of, run);
  run.meshes = read_meshes(directory / "meshes.json", run.mesh_parts);
  return run;
}

Recording read_recording(const std::filesystem::path& directory, double every) {
  require_result_folder(directory);
  const BodyTable table(directory / "bodies.csv");
  Recording run = read_world(directory, table);
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

MeshParts Recording::parts_of(const RecordedBody& body, std::size_t shape) const {
  const int number = shape < body.meshes.size() ? body.meshes[shape] : -1;
  return number < 0 || static_cast<std::size_t>(number) >= meshes.size() ? MeshParts{} : meshes[static_cast<std::size_t>(number)];
}

Vec3 nearest_on(const RecordedBody& body, const Vec3& point, const Vec3& otherwise, double least) {
  Vec3 best = otherwise;
  for (const auto& [from, to] : body.extent) {
    const Vec3 along = to - from;
    const double length = dot(along, along);
    const Vec3 near = from + (length > 0 ? std::clamp(dot(point - from, along) / length, 0.0, 1.0) : 0.0) * along;
    if (norm(near - point) < least) best = near, least = norm(near - point);
  }
  return best;
}

}  // namespace momentree::io
