#include <momentree/scenario/scenario.hpp>

#include <algorithm>
#include <filesystem>
#include <utility>

#include <momentree/base/characters.hpp>
#include <momentree/scenario/known_scenario.hpp>
#include <momentree/scenario/override.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/text/files/input_cache.hpp>
#include <momentree/text/hash.hpp>
#include <momentree/text/toml.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr Key keys_entries[] = {
    {"format", other(R"({"const": 1})"), "Version of the format"},
    {"title", string, "Title, shown with the results"},
    {"world", table(world_table), ""},
    {"state", string, "State document to start from, such as the final.json of another run"},
    {"mechanism", tables(mechanism_table), "The mechanisms", nullptr, "add [[mechanism]] tables"},
    {"force", tables(force_table), "External forces on bodies"},
    {"loop", tables(loop_table), "Joints that close loops"},
    {"contact", tables(contact_table), "Friction and restitution where bodies touch"},
    {"event", tables(event_table), "The events"},
    {"integrate", table(integrate_table), ""},
    {"output", table(output_table), ""},
};

constexpr std::uintmax_t largest_file = 256u << 20;
constexpr std::size_t largest_unknown = 1u << 20;  // limit for files not recognised as scenarios: larger ones are not read

void read_format(Fields& fields, Diagnostics& out) {
  const Value* format = fields.find("format");
  if (!format) return out.warning({1, 1, 0}, "the scenario does not state its format", "begin it with format = 1");
  const std::int64_t* n = format->integer();
  if (!n || *n != 1)
    out.error(format->place, n ? "format " + std::to_string(*n) + " is not supported by this version" : "format: expected 1",
              "this version reads format 1");
}

// The title appears in pictures, tables and comments of generated code: it must be one visible line.
void read_title(Fields& fields, Reading& reading) {
  std::string title = fields.string("title").value_or("");
  if (first_invisible(title) == std::string::npos)
    reading.scenario.title = std::move(title);
  else
    reading.out.error(fields.place_of("title"), "title: " + in_quotes(title) + " has an invisible character",
                      "a title is one line without control characters");
}

void read_state_file(Fields& fields, Reading& reading) {
  const auto file = fields.string("state");
  if (!file) return;
  if (file->empty()) reading.out.error(fields.place_of("state"), "state: expected the name of a file");
  const bool relative = !reading.folder.empty() && file->front() != '/';
  reading.scenario.state_files.push_back({relative ? reading.folder + "/" + *file : *file, "", fields.place_of("state")});
}

// Checks of the whole model. A body with a duplicate name was never added, and needs no further message.
void check_whole(Reading& reading) {
  Diagnostics& out = reading.out;
  if (!loops_fit(reading)) return;
  const std::size_t errors = out.errors() + reading.model_errors();
  for (const SingularJoint& singular : singular_joints(reading.scenario.model)) {
    const std::string& joint = reading.scenario.model[singular.body].joint_name;
    const std::string what = "joint " + in_quotes(joint) + ": " + singular.what;
    if (const auto spots = reading.from_model.find(joint); spots != reading.from_model.end())
      spots->second.file->error({spots->second.joint ? spots->second.joint : spots->second.body}, what, singular.hint);
    else
      out.error(reading.joints.at(joint), what, singular.hint);
  }
  if (errors == 0 && out.errors() + reading.model_errors() == 0) check_loops(reading);
  if (errors == 0 && out.errors() + reading.model_errors() == 0) check_contacts(reading);
  if (errors == 0 && out.errors() + reading.model_errors() == 0) {
    check_tolerance(reading);
    check_integration(reading);
    check_events(reading);
  }
}

void read_document(const Value& document, Reading& reading) {
  Diagnostics& out = reading.out;
  if (const Value::Entry* vary = document.find("vary"); vary != nullptr && document.find("mechanism") == nullptr)
    return out.error(vary->place, "this is a sweep, not a scenario of one world", "`momentree sweep` runs it");
  Fields fields(document, scenario_table, out);
  read_format(fields, out);
  read_title(fields, reading);
  if (const Value* world = fields.find("world")) read_world(*world, reading);
  read_state_file(fields, reading);
  const auto each = [&](const char* key, const auto& read) {
    const Value* const tables = fields.find(key);
    if (tables == nullptr) return false;
    for (const Value* table : tables_of(*tables, key, out)) {
      if (out.full()) break;
      read(*table, reading);
    }
    return true;
  };
  if (!each("mechanism", read_mechanism)) out.error({1, 1, 0}, "the scenario has no mechanism", "add [[mechanism]] tables");
  each("force", read_force);
  each("loop", read_loop);
  for (const ElementTable& element : element_tables()) each(element.keys->definition, element.read);
  add_model_colliders(document.find("contact") != nullptr, reading);
  each("contact", read_contact);
  int number = 0;
  each("event", [&](const Value& event, Reading& all) { read_event(event, ++number, all); });
  check_couplings(reading);
  finish_events(reading);
  if (const Value* integrate = fields.find("integrate")) read_integrate(*integrate, reading);
  if (const Value* output = fields.find("output")) read_output(*output, reading);
  fields.later({"scenario", "worlds", "seed", "vary", "measure"}, "this is a scenario of one world, not a sweep");
  fields.finish();
  check_whole(reading);
}

// A valid mechanism name made from a file name.
std::string mechanism_name(const std::string& stem) {
  std::string name = stem.substr(0, 200);
  for (char& c : name)
    if (c == ',' || c == '"' || c == '*' || c == '/') c = '_';
  for (std::size_t i = 0; (i = first_invisible(name)) != std::string::npos;)
    name.replace(i, std::max<std::size_t>(character_length(name, i), 1), "_");
  if (!name.empty() && name.front() == '#') name.front() = '_';
  return name.empty() || name == "ground" || name == "." || name == ".." ? "model" : name;
}

// The document of a scenario with this model alone.
Value document_of(const std::string& name, const std::string& file, const ImportedModel& model) {
  const Place nowhere{};
  const auto entry = [&](const char* key, auto value) { return Value::Entry{key, nowhere, Value(std::move(value), nowhere)}; };
  Value::Table mechanism{entry("name", name), entry("model", file)};
  Value::Table document{entry("format", std::int64_t{1})};
  if (!model.title.empty()) document.push_back(entry("title", printable(model.title)));
  if (const auto& g = model.gravity) {
    Value::Array gravity{{g->x, nowhere}, {g->y, nowhere}, {g->z, nowhere}};
    document.push_back(entry("world", Value::Table{entry("gravity", std::move(gravity))}));
  }
  document.push_back(entry("mechanism", Value::Array{Value(std::move(mechanism), nowhere)}));
  return {std::move(document), nowhere};
}

// The origin of a text.
struct Origin {
  std::string path, name, folder;
  bool looks_at_files = true;
  explicit Origin(const std::string& file)
      : path(file),
        name(std::filesystem::path(file).stem().string()),
        folder(std::filesystem::path(file).parent_path().string()) {}
};

// `parsed`: the document of the text, if it is known.
ReadResult read_text(std::string text, const Origin& origin, const std::vector<std::string>& overrides,
                     const Value* parsed = nullptr, std::shared_ptr<InputCache> inputs = nullptr) {
  namespace fs = std::filesystem;
  const std::string& path = origin.path;
  ReadResult result;
  Scenario scenario;
  scenario.path = path;
  scenario.name = origin.name;
  scenario.text = std::move(text);
  scenario.inputs = std::move(inputs);
  Hash hash;
  hash.add(scenario.text);
  for (const std::string& each : overrides) {
    hash.add("\n--set ");
    hash.add(each);
  }
  const bool quotes = is_known_scenario(scenario.text);
  Diagnostics out(path, quotes ? std::string_view(scenario.text) : std::string_view(), overrides);
  Reading reading{scenario, out, origin.folder, origin.looks_at_files ? Enclosure(path) : Enclosure(), origin.looks_at_files};
  SyntaxError error;
  std::optional<Value> document;
  reading.direct = is_model(path, scenario.text);
  const bool is_parsed = parsed != nullptr && !reading.direct;
  if (reading.direct) {
    const std::string file = fs::path(path).filename().string(), folder = reading.folder.empty() ? "." : reading.folder;
    std::shared_ptr<Import> kept = scenario.inputs ? scenario.inputs->model(file) : nullptr;
    if (!kept) kept = read_model_text(path, scenario.text, origin.looks_at_files ? folder : "");
    reading.models.emplace_back(file, std::move(kept));
    const Import& import = *reading.models.back().second;
    if (import.errors() == 0) document = document_of(mechanism_name(scenario.name), file, import.model);
  } else if (is_parsed) {
    document = *parsed;
  } else if (!quotes && scenario.text.size() > largest_unknown) {
    out.error({}, "this is not a scenario: no line states the format, and none begins a mechanism",
              "a scenario begins with format = 1");
  } else {
    document = parse_toml(scenario.text, error);
    if (!document && !quotes && error.quotes)
      out.error(error.place, "this is not a scenario: it cannot be read as TOML", "a scenario begins with format = 1");
    else if (!document)
      out.error(error.place, error.what, error.hint);
  }
  if (document) {
    apply_overrides(*document, overrides, out);
    read_document(*document, reading);
    scenario.document = std::make_shared<const Value>(std::move(*document));
  }
  scenario.shapes.resize(static_cast<std::size_t>(scenario.model.size()));
  const bool good = out.errors() + reading.model_errors() == 0;
  result.diagnostics = out.take();
  for (const auto& [name, import] : reading.models) {
    const bool is_kept = scenario.inputs && scenario.inputs->model(name) == import;
    for (const auto& file : import->files()) {
      const bool known = reading.direct && file == import->files().front();
      if (!known) hash.add("\n--model "), hash.add(file->text());
      result.model_files.push_back(file->path());
      if (is_kept) continue;  // its warnings have been given
      for (Diagnostic& each : file->take()) result.diagnostics.push_back(std::move(each));
    }
    if (scenario.inputs && !is_kept && import->errors() == 0) scenario.inputs->keep(name, import);
  }
  scenario.hash = hash.digits();
  if (good) result.scenario = std::move(scenario);
  return result;
}

ReadResult refused(const std::string& path, std::string what, std::string hint) {
  return {std::nullopt, {{Severity::error, path, 0, 0, std::move(what), std::move(hint), ""}}};
}

}  // namespace

void note_collision_shapes(const Model& model, std::vector<Shape> added, std::vector<Shape>& all) {
  all.resize(model.colliders().size());
  std::move(added.begin(), added.end(), all.end() - static_cast<std::ptrdiff_t>(added.size()));
}

constinit const KeyTable scenario_table{
    .name = "a scenario",
    .definition = "",
    .about = "A scenario: mechanisms, events, and the settings for integration and output",
    .own = keys_entries,
    .described = [] {
      static const std::vector<Key> keys = [] {
        std::vector<Key> all;
        for (const ElementTable& element : element_tables())
          all.push_back({element.keys->definition, tables(*element.keys), element.keys->about});
        return all;
      }();
      return KeyList(keys);
    }};

ReadResult read_scenario(const std::string& path, const std::vector<std::string>& overrides) {
  std::string text;
  Unreadable why;
  if (!read_whole_file(path, "scenario", largest_file, text, why)) return refused(path, why.what, why.hint);
  if (text.size() > largest_model && is_model(path, text))
    return refused(path, "is larger than " + std::to_string(largest_model >> 20) + " MiB, the limit for a model", "");
  return read_text(std::move(text), Origin(path), overrides);
}

ReadResult read_scenario_again(const Scenario& scenario, const std::vector<std::string>& overrides) {
  Origin origin(scenario.path);
  origin.name = scenario.name;
  return read_text(scenario.text, origin, overrides, scenario.document.get(), scenario.inputs);
}

ReadResult read_scenario_from(std::string text, const std::string& path, const std::string& name, const std::string& folder,
                              const std::vector<std::string>& overrides) {
  if (text.size() > largest_model && is_model(path, text))
    return refused(path, "is larger than " + std::to_string(largest_model >> 20) + " MiB, the limit for a model", "");
  Origin origin(path);
  origin.name = name, origin.folder = folder;
  return read_text(std::move(text), origin, overrides);
}

ReadResult read_scenario_text(std::string_view text, const std::string& path, const std::vector<std::string>& overrides) {
  Origin origin(path);
  origin.looks_at_files = false;
  return read_text(std::string(text), origin, overrides);
}

}  // namespace momentree::io
