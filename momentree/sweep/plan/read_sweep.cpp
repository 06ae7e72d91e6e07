#include <momentree/sweep/plan/read_sweep.hpp>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

#include <momentree/base/characters.hpp>
#include <momentree/base/error.hpp>
#include <momentree/scenario/convert/toml_writer.hpp>
#include <momentree/scenario/override.hpp>
#include <momentree/sweep/plan/sweep_keys.hpp>
#include <momentree/sweep/plan/sweep_reading.hpp>
#include <momentree/sweep/shared_inputs.hpp>
#include <momentree/text/files/input_cache.hpp>
#include <momentree/text/files/input_file.hpp>
#include <momentree/text/files/text_file.hpp>
#include <momentree/text/hash.hpp>
#include <momentree/text/toml.hpp>

namespace momentree::sweep {

namespace {

namespace fs = std::filesystem;
using io::Fields;

constexpr std::uintmax_t largest_sweep = 64u << 20;

std::optional<std::int64_t> whole_number(Fields& fields, const char* key, std::int64_t least, io::Diagnostics& out) {
  const Value* value = fields.find(key);
  if (value == nullptr) return std::nullopt;
  return io::read_whole(*value, key, least, std::numeric_limits<std::int64_t>::max(), out);
}

void read_format(Fields& fields, io::Diagnostics& out) {
  const Value* format = fields.find("format");
  if (format == nullptr) return out.warning({1, 1, 0}, "the sweep does not state its format", "begin it with format = 1");
  const std::int64_t* number = format->integer();
  if (number == nullptr || *number != 1)
    out.error(format->place,
              number ? "format " + std::to_string(*number) + " is not supported by this version" : "format: expected 1",
              "this version reads format 1");
}

// Without `sweeps/..`, unless a symbolic link makes that another file.
std::string scenario_path(const std::string& sweep, const std::string& scenario) {
  const fs::path path = fs::path(sweep).parent_path() / scenario, shorter = path.lexically_normal();
  std::error_code failed;
  return (fs::equivalent(path, shorter, failed) && !failed ? shorter : path).string();
}

void read_output(const Value& table, SweepReading& reading) {
  Fields fields(table, output_table, reading.out);
  reading.sweep.output = fields.string("file").value_or("");
  if (fields.has("file") && reading.sweep.output.empty())
    reading.out.error(fields.place_of("file"), "file: expected the name of a folder or file");
  reading.sweep.json_lines = fields.boolean("json_lines").value_or(false);
  if (reading.sweep.json_lines && reading.sweep.output.ends_with(".h5"))
    reading.out.error(fields.place_of("json_lines"), "json_lines: goes with a folder", "omit it, or give file a folder");
  fields.finish();
}

// The scenario of the sweep; null, with reports, if it cannot be read. Its own errors are reported as they are.
std::shared_ptr<const io::Scenario> read_scenario_of(const Value& value, SweepReading& reading,
                                                     std::vector<io::Diagnostic>& of_scenario) {
  const auto name = io::read_string(value, "scenario", reading.out);
  if (!name) return nullptr;
  const std::string path = scenario_path(reading.sweep.path, *name);
  if (const auto why = io::why_unreadable(path, "scenario")) {
    reading.out.error(value.place, "scenario: " + io::in_quotes(*name) + " " + why->what, why->hint);
    return nullptr;
  }
  io::ReadResult read = io::read_scenario(path);
  if (!read.scenario) {
    reading.out.error(value.place, "scenario: " + io::in_quotes(*name) + " has errors", "they are listed below");
    of_scenario = std::move(read.diagnostics);
    return nullptr;
  }
  read.scenario->inputs = std::make_shared<SharedInputs>();  // all worlds have the models that are there now
  return std::make_shared<const io::Scenario>(std::move(*read.scenario));
}

// Two parameters must not set the same value: the last one would win, and the others be shown without having an effect.
void check_overlaps(SweepReading& reading) {
  std::vector<std::pair<std::vector<std::string>, const Parameter*>> places;
  for (const Parameter& parameter : reading.sweep.parameters) {
    std::vector<std::string> place = io::place_of_key(*reading.sweep.scenario->document, parameter.key);
    if (!place.empty()) places.emplace_back(std::move(place), &parameter);
  }
  // In this order, what begins with a place follows it.
  std::stable_sort(places.begin(), places.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 1; i < places.size(); ++i) {
    const auto& [outer, first] = places[i - 1];
    const auto& [inner, second] = places[i];
    if (outer.size() > inner.size() || !std::equal(outer.begin(), outer.end(), inner.begin())) continue;
    reading.out.error(second->place, io::in_quotes(second->key) + " and " + io::in_quotes(first->key) + " vary the same value",
                      "keep one of them");
  }
}

// `tried`: of try_parameters().
std::string hash_of(const Sweep& sweep, const std::string& tried) {
  io::Hash hash;
  hash.add(sweep.text);
  hash.add("\n--scenario ");
  hash.add(sweep.scenario->hash);
  for (const io::StateFile& file : sweep.scenario->state_files) {
    hash.add("\n--state ");
    hash.add(sweep.scenario->inputs->text(file.file));
  }
  hash.add("\n--tried ");
  hash.add(tried);
  return hash.digits();
}

void make_plan(const Value& vary, std::optional<std::int64_t> worlds, std::vector<Correlation> correlations,
               SweepReading& reading) {
  const auto is_drawn = [](const Variable& variable) { return std::holds_alternative<Sampled>(variable.values); };
  if (!worlds && std::all_of(reading.variables.begin(), reading.variables.end(), is_drawn))
    return reading.out.error(vary.place, "[vary]: every value is drawn at random, but the number of worlds is not given",
                             "worlds = 1000");
  reading.sweep.correlations = correlations;
  try {
    reading.sweep.plan = std::make_shared<const Plan>(reading.variables,
                                                      worlds ? std::optional(static_cast<std::uint64_t>(*worlds)) : std::nullopt,
                                                      reading.sweep.seed, std::move(correlations));
  } catch (const Error& error) {
    Place place = vary.place;  // a message about one of the parameters begins with its key
    for (const Parameter& parameter : reading.sweep.parameters)
      if (error.problem.find(parameter.key) != std::string::npos) place = parameter.place;
    reading.out.error(place, error.problem, error.hint);
  }
}

// The same for the same values of all worlds, however they are written.
std::string plan_hash_of(const Value& vary, const Value* correlated, const Sweep& sweep) {
  io::Hash hash;
  hash.add(io::toml_value_text(vary));
  hash.add("\n--correlated ");
  if (correlated != nullptr) hash.add(io::toml_value_text(*correlated));
  hash.add("\n--seed " + std::to_string(sweep.seed) + " --worlds " + std::to_string(sweep.worlds()));
  return hash.digits();
}

void read_document(const Value& document, SweepReading& reading, std::vector<io::Diagnostic>& of_scenario) {
  io::Diagnostics& out = reading.out;
  Sweep& sweep = reading.sweep;
  Fields fields(document, sweep_table, out);
  read_format(fields, out);
  sweep.title = fields.string("title").value_or("");
  if (first_invisible(sweep.title) != std::string::npos)
    out.error(fields.place_of("title"), "title: it has an invisible character", "a title is one line without control characters");
  const std::optional<std::int64_t> worlds = whole_number(fields, "worlds", 1, out);
  sweep.seed = static_cast<std::uint64_t>(whole_number(fields, "seed", 0, out).value_or(0));
  const Value *scenario = fields.require("scenario"), *vary = fields.require("vary"), *measure = fields.require("measure"),
              *stop = fields.find("stop"), *correlated = fields.find("correlated");
  if (const Value* output = fields.find("output")) read_output(*output, reading);
  fields.finish();
  if (vary != nullptr) {
    const Value::Table& entries = io::read_table(*vary, "[vary]", out);
    if (vary->table() != nullptr && entries.empty())
      out.error(vary->place, "[vary]: nothing is varied", "for example \"event.grasp.when.below\" = { uniform = [0.2, 0.4] }");
    for (const Value::Entry& entry : entries) {
      if (out.full()) break;
      read_vary(entry, reading);
    }
  }
  std::vector<Correlation> correlations;
  if (correlated != nullptr) correlations = read_correlations(*correlated, reading);
  if (scenario != nullptr) sweep.scenario = read_scenario_of(*scenario, reading, of_scenario);
  if (vary != nullptr && out.errors() == 0) make_plan(*vary, worlds, std::move(correlations), reading);
  if (sweep.plan) sweep.plan_hash = plan_hash_of(*vary, correlated, sweep);
  if (!sweep.scenario) return;
  try {
    io::Session session(sweep.scenario);
    const std::vector<io::Diagnostic> warnings = session.schedule();
    sweep.joints = session.joints();
    if (measure != nullptr) read_measures(*measure, session, reading);
    if (stop != nullptr) read_stop(*stop, session.simulation(), reading);
  } catch (const Error& error) {
    out.error(scenario->place, "scenario: " + error.problem, error.hint);
    return;
  }
  if (vary == nullptr || out.full()) return;
  check_overlaps(reading);
  reading.vary = vary->place;
  try {
    sweep.hash = hash_of(sweep, try_parameters(reading));
  } catch (const Error& error) {
    out.error(vary->place, "[vary]: " + error.problem, error.hint);
  }
}

ReadSweep refused(const std::string& path, std::string what, std::string hint) {
  return {std::nullopt, {{io::Severity::error, path, 0, 0, std::move(what), std::move(hint), ""}}};
}

}  // namespace

ReadSweep read_sweep(const std::string& path) {
  std::string text;
  io::Unreadable why;
  if (!io::read_whole_file(path, "sweep", largest_sweep, text, why)) return refused(path, why.what, why.hint);
  return read_sweep_text(std::move(text), path);
}

ReadSweep read_sweep_text(std::string text, const std::string& path) {
  Sweep sweep;
  sweep.path = path;
  sweep.name = fs::path(path).stem().string();
  sweep.text = std::move(text);
  io::SyntaxError error;
  const std::optional<Value> document = io::parse_toml(sweep.text, error);
  if (document && document->find("mechanism") != nullptr)
    return refused(path, "this is a scenario of one world, not a sweep",
                   "write a sweep file that names it: scenario = \"" + fs::path(path).filename().string() + "\"");
  io::Diagnostics out(path, is_sweep(sweep.text) ? std::string_view(sweep.text) : std::string_view());
  std::vector<io::Diagnostic> of_scenario;
  if (!document) {
    if (error.quotes && !is_sweep(sweep.text))
      out.error(error.place, "this is not a sweep: it cannot be read as TOML", "a sweep begins with format = 1");
    else
      out.error(error.place, error.what, error.hint);
  } else {
    SweepReading reading{sweep, out};
    read_document(*document, reading, of_scenario);
  }
  const bool good = out.errors() == 0;
  ReadSweep result{std::nullopt, out.take()};
  result.diagnostics.insert(result.diagnostics.end(), of_scenario.begin(), of_scenario.end());
  if (good) result.sweep = std::move(sweep);
  return result;
}

bool is_sweep(std::string_view text) {
  bool scenario = false;
  while (!text.empty()) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.starts_with("[[mechanism") || line.starts_with("[mechanism")) return false;
    if (line.starts_with("[vary]") || line.starts_with("[vary.")) return true;
    const std::size_t equals = line.find('=');
    std::string_view key = line.substr(0, equals == std::string_view::npos ? 0 : equals);
    while (key.ends_with(' ') || key.ends_with('\t')) key.remove_suffix(1);
    scenario = scenario || key == "scenario" || key == "vary";
  }
  return scenario;
}

}  // namespace momentree::sweep
