#include <momentree/io/report/report.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include <momentree/base/error.hpp>
#include <momentree/io/json.hpp>
#include <momentree/io/json_writer.hpp>
#include <momentree/io/picture/body_table.hpp>
#include <momentree/io/report/base64.hpp>
#include <momentree/io/report/page.hpp>
#include <momentree/io/text_file.hpp>

namespace momentree::io {

namespace {

namespace fs = std::filesystem;

/// The names of the bodies, whose columns must be in the order in which a run writes them.
std::vector<std::string> body_names(const NumberTable& table) {
  std::vector<std::string> names;
  for (const PoseColumns& body : find_bodies(table)) {
    for (std::size_t k = 0; k < 7; ++k)
      if (body.at[k] != 7 * names.size() + k)
        throw_error({"column '" + table.columns()[body.at[k]] + "' is not in its place", table.place(),
                     "bodies.csv as written by `momentree run` is needed"});
    names.push_back(body.name);
  }
  return names;
}

/// Every n-th row, so that at most `most` are left, and the last one.
std::vector<std::size_t> thinned(std::size_t rows, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (rows + most - 1) / std::max<std::size_t>(most, 1));
  std::vector<std::size_t> kept;
  for (std::size_t row = 0; row < rows; row += step) kept.push_back(row);
  if (kept.back() + 1 != rows) kept.push_back(rows - 1);
  return kept;
}

/// Writes a document that is already JSON as a value.
void raw(JsonWriter& json, std::string& text, std::string_view document) {
  json.null();
  text.resize(text.size() - 4);
  text += document;
}

void write_names(JsonWriter& json, const char* key, const std::vector<std::string>& names) {
  json.key(key).begin_array();
  for (const std::string& name : names) json.value(name);
  json.end_array();
}

void write_some(JsonWriter& json, const char* key, const std::vector<std::string>& names) {
  if (!names.empty()) write_names(json, key, names);
}

/// Equal adjacent numbers are written as a pair of count and number.
void write_mechanisms(JsonWriter& json, const std::vector<int>& mechanism) {
  json.key("mechanism").begin_array();
  for (std::size_t b = 0; b < mechanism.size();) {
    const std::size_t begin = b;
    while (b < mechanism.size() && mechanism[b] == mechanism[begin]) ++b;
    json.begin_array().value(static_cast<long>(b - begin)).value(mechanism[begin]).end_array();
  }
  json.end_array();
}

void write_phases(JsonWriter& json, const Recording& run) {
  json.key("phases").begin_array();
  const Phase* last = nullptr;
  for (const Phase& phase : run.phases) {
    const bool quiet = phase.gone.empty() && phase.joints.empty() && last != nullptr && last->mechanism == phase.mechanism;
    if (quiet) continue;
    last = &phase;
    json.begin_object().member("from", phase.from);
    write_mechanisms(json, phase.mechanism);
    write_some(json, "gone", phase.gone);
    if (!phase.joints.empty()) {
      json.key("joints").begin_array();
      for (const RecordedJoint& joint : phase.joints)
        json.begin_object()
            .member("joint", joint.name)
            .member("kind", joint.kind)
            .member("parent", joint.parent)
            .member("child", joint.child)
            .member("at", joint.at)
            .member("childAt", joint.child_at)
            .member("locked", joint.locked)
            .end_object();
      json.end_array();
    }
    json.end_object();
  }
  json.end_array();
}

/// The lines of events.jsonl, and for each event the bodies concerned.
void write_events(JsonWriter& json, std::string& text, const fs::path& file, const Recording& run) {
  const std::string lines = is_there(file) ? read_text_file(file.string(), Links::refuse) : "";
  json.key("events").begin_array();
  std::size_t written = 0;
  for (std::size_t at = 0; at < lines.size() && written < run.events.size();) {
    const std::size_t end = std::min(lines.find('\n', at), lines.size());
    const std::string_view line = std::string_view(lines).substr(at, end - at);
    if (line.find_first_not_of(" \t\r") != std::string_view::npos) raw(json, text, line), ++written;
    at = end + 1;
  }
  json.end_array().key("about").begin_array();
  for (const RecordedEvent& event : run.events) {
    json.begin_array();
    for (const int body : event.about) json.value(body);
    json.end_array();
  }
  json.end_array();
}

void write_table(JsonWriter& json, std::string& text, const char* key, const NumberTable& table,
                 const std::vector<std::size_t>& rows, bool precise) {
  json.key(key).begin_object();
  write_names(json, "columns", table.columns());
  std::string numbers;
  (precise ? append_doubles : append_floats)(numbers, table.read(rows, NumberTable::Gaps::allowed));
  json.key("rows");
  raw(json, text, '"' + numbers + '"');
  json.end_object();
}

/// A table that may be missing.
std::optional<NumberTable> table_of(const fs::path& file) {
  if (!is_there(file)) return std::nullopt;
  return NumberTable(file);
}

std::string document(const fs::path& file) {
  std::string text = read_text_file(file.string(), Links::refuse);
  parse_json(text, file.string());  // or throws
  return text;
}

}  // namespace

std::string report_data(const fs::path& directory, const ReportOptions& options) {
  if (!fs::is_directory(directory))
    throw_error({"there is no such directory", directory.string(), "run the scenario first: momentree run SCENARIO --out DIR"});
  const fs::path model = directory / "model.json", summary = directory / "summary.json";
  if (!is_there(model)) throw_error({"it has no model.json", directory.string(), "was the run killed? run it again"});
  const NumberTable bodies(directory / "bodies.csv");
  const std::vector<std::string> names = body_names(bodies);
  std::optional<NumberTable> joints = table_of(directory / "joints.csv");
  const std::optional<NumberTable> energy = table_of(directory / "energy.csv");
  std::size_t count = bodies.times().size();  // a killed run may have written fewer rows of one table than of another
  if (joints) count = std::min(count, joints->times().size());
  if (energy) count = std::min(count, energy->times().size());
  if (count == 0) throw_error({"its tables have no complete row", directory.string(), "the run stopped before it wrote one"});

  const std::size_t width = bodies.columns().size();
  const auto affordable = [&](std::size_t columns) { return std::max<std::size_t>(options.most_numbers / columns, 60); };
  std::size_t most = affordable(width + (joints ? joints->columns().size() : 0));
  const bool left_out = joints && most < std::min<std::size_t>(count, 300);
  if (left_out) joints.reset(), most = affordable(width);
  std::vector<std::size_t> rows = thinned(count, most);
  std::vector<double> poses = bodies.read(rows, NumberTable::Gaps::allowed);
  const auto infinite = std::find_if(poses.begin(), poses.end(), [](double x) { return std::isinf(x); });
  rows.resize(static_cast<std::size_t>(infinite - poses.begin()) / width);
  if (rows.empty()) throw_error({"its first row has no finite poses", (directory / "bodies.csv").string(), ""});
  poses.resize(rows.size() * width);

  const Recording run = read_story(directory, names);
  std::string text;
  JsonWriter json(text);
  json.begin_object().member("format", 1).member("pose", options.pose);
  json.member("thinned", rows.size() < count).member("joints_left_out", left_out);
  write_names(json, "bodies", names);
  json.key("model");
  raw(json, text, document(model));
  json.key("summary");
  raw(json, text, !options.summary.empty() ? options.summary : is_there(summary) ? document(summary) : "null");
  write_names(json, "mechanisms", run.mechanisms);
  write_phases(json, run);
  write_events(json, text, directory / "events.jsonl", run);
  std::vector<double> times;
  for (const std::size_t row : rows) times.push_back(bodies.times()[row]);
  std::string numbers;
  append_doubles(numbers, times);
  json.member("frames", static_cast<long>(rows.size())).key("time");
  raw(json, text, '"' + numbers + '"');
  numbers.clear();
  append_floats(numbers, poses);
  json.key("poses");
  raw(json, text, '"' + numbers + '"');
  if (joints) write_table(json, text, "joints", *joints, rows, false);
  if (energy) write_table(json, text, "energy", *energy, rows, true);
  json.end_object();

  return json_for_page(text);
}

}  // namespace momentree::io
