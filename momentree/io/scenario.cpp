#include <momentree/io/scenario.hpp>

#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include <momentree/io/override.hpp>
#include <momentree/io/scenario_parts.hpp>
#include <momentree/io/toml.hpp>

namespace momentree::io {

namespace {

constexpr std::uintmax_t largest_file = 256u << 20;

// FNV-1a, 64 bits: the same on every machine; names an input, protects nothing.
std::string hash_of(std::string_view text, const std::vector<std::string>& overrides) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](std::string_view part) {
    for (const char c : part) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  };
  add(text);
  for (const std::string& each : overrides) {
    add("\n--set ");
    add(each);
  }
  std::string digits(16, '0');
  for (std::size_t i = 16; i-- > 0; hash >>= 4) digits[i] = "0123456789abcdef"[hash & 15];
  return digits;
}

void read_format(Fields& fields, Diagnostics& out) {
  const Value* format = fields.find("format");
  if (!format) return out.warning({1, 1, 0}, "the scenario does not say its format", "begin it with format = 1");
  const std::int64_t* n = format->integer();
  if (!n || *n != 1)
    out.error(format->place, n ? "format " + std::to_string(*n) + " is not known to this version" : "format: expected 1",
              "this version reads format 1");
}

void read_state_file(Fields& fields, Reading& reading) {
  const auto file = fields.string("state");
  if (!file) return;
  if (file->empty()) reading.out.error(fields.place_of("state"), "state: expected the name of a file");
  const bool relative = !reading.folder.empty() && file->front() != '/';
  reading.scenario.state_files.push_back({relative ? reading.folder + "/" + *file : *file, "", fields.place_of("state")});
}

// What only the whole model shows. A body that holds a name twice was never added: no more to say.
void check_whole(Reading& reading) {
  Diagnostics& out = reading.out;
  const std::size_t errors = out.errors();
  for (const SingularJoint& singular : singular_joints(reading.scenario.model)) {
    const std::string& joint = reading.scenario.model[singular.body].joint_name;
    out.error(reading.joints.at(joint), "joint " + in_quotes(joint) + ": " + singular.what, singular.hint);
  }
  if (errors == 0 && errors == out.errors()) {
    check_tolerance(reading);
    check_events(reading);
  }
}

void read_document(const Value& document, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(document, "a scenario", out);
  read_format(fields, out);
  reading.scenario.title = fields.string("title").value_or("");
  if (const Value* world = fields.find("world")) read_world(*world, reading);
  read_state_file(fields, reading);
  if (const Value* mechanisms = fields.find("mechanism")) {
    for (const Value* mechanism : tables_of(*mechanisms, "mechanism", out)) {
      if (out.full()) break;
      read_mechanism(*mechanism, reading);
    }
  } else {
    out.error({1, 1, 0}, "the scenario has no mechanism", "add [[mechanism]] tables");
  }
  if (const Value* forces = fields.find("force")) {
    for (const Value* force : tables_of(*forces, "force", out)) {
      if (out.full()) break;
      read_force(*force, reading);
    }
  }
  if (const Value* events = fields.find("event")) {
    int number = 0;
    for (const Value* event : tables_of(*events, "event", out)) {
      if (out.full()) break;
      read_event(*event, ++number, reading);
    }
  }
  finish_events(reading);
  if (const Value* integrate = fields.find("integrate")) read_integrate(*integrate, reading);
  if (const Value* output = fields.find("output")) read_output(*output, reading);
  fields.later({"loop"}, "closed loops are not supported: a mechanism is a tree");
  fields.finish();
  check_whole(reading);
}

ReadResult read_text(std::string text, const std::string& path, const std::vector<std::string>& overrides, bool looks_at_files) {
  ReadResult result;
  Scenario scenario;
  scenario.path = path;
  scenario.name = std::filesystem::path(path).stem().string();
  scenario.hash = hash_of(text, overrides);
  scenario.text = std::move(text);
  Diagnostics out(path, scenario.text, overrides);
  SyntaxError error;
  std::optional<Value> document = parse_toml(scenario.text, error);
  if (document) {
    apply_overrides(*document, overrides, out);
    Reading reading{scenario, out, std::filesystem::path(path).parent_path().string(), looks_at_files};
    read_document(*document, reading);
  } else {
    out.error(error.place, error.what, error.hint);
  }
  scenario.shapes.resize(static_cast<std::size_t>(scenario.model.size()));
  const bool good = out.errors() == 0;
  result.diagnostics = out.take();
  if (good) result.scenario = std::move(scenario);
  return result;
}

ReadResult refused(const std::string& path, std::string what, std::string hint) {
  return {std::nullopt, {{Severity::error, path, 0, 0, std::move(what), std::move(hint), ""}}};
}

}  // namespace

ReadResult read_scenario(const std::string& path, const std::vector<std::string>& overrides) {
  std::error_code failed;
  const auto status = std::filesystem::status(path, failed);
  if (!std::filesystem::exists(status)) return refused(path, "there is no such file", "");
  if (std::filesystem::is_directory(status)) return refused(path, "is a folder, not a scenario", "name the .toml file in it");
  if (!std::filesystem::is_regular_file(status)) return refused(path, "is not a regular file", "");
  const std::uintmax_t size = std::filesystem::file_size(path, failed);
  if (failed) return refused(path, "cannot be read: " + failed.message(), "");
  if (size > largest_file) return refused(path, "is larger than 256 MiB: this is no scenario", "");
  std::ifstream file(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!file || !file.read(text.data(), static_cast<std::streamsize>(size)))
    return refused(path, "cannot be read", "is it yours to read?");
  return read_text(std::move(text), path, overrides, true);
}

ReadResult read_scenario_text(std::string_view text, const std::string& path, const std::vector<std::string>& overrides) {
  return read_text(std::string(text), path, overrides, false);
}

}  // namespace momentree::io
