#include <momentree/results/report/report.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include <momentree/base/error.hpp>
#include <momentree/results/columns/contact_columns.hpp>
#include <momentree/results/recording/body_table.hpp>
#include <momentree/results/recording/number_table.hpp>
#include <momentree/results/recording/recording.hpp>
#include <momentree/results/report/page.hpp>
#include <momentree/scenario/state/joint_json.hpp>
#include <momentree/text/base64.hpp>
#include <momentree/text/files/text_file.hpp>
#include <momentree/text/json.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

namespace {

namespace fs = std::filesystem;

/// The number of rows that the page of a run needs.
std::size_t useful_rows(double duration, std::size_t columns, std::size_t plenty) {
  const double by_time = std::min(std::max(60 * duration, 600.0), 3000.0);
  return std::max(plenty / columns, static_cast<std::size_t>(by_time));
}

/// The rows just before, at and just after events; at most `most`.
std::vector<std::size_t> rows_next_to(const std::vector<double>& events, std::span<const double> times, std::size_t most) {
  std::vector<std::size_t> rows;
  for (const double event : events) {
    const auto [from, to] = std::equal_range(times.begin(), times.end(), event);
    const std::size_t first = from == times.begin() ? 0 : static_cast<std::size_t>(from - times.begin()) - 1;
    const std::size_t last = std::min(static_cast<std::size_t>(to - times.begin()), times.size() - 1);
    for (std::size_t row = first; row <= last && rows.size() < most; ++row) rows.push_back(row);
  }
  return rows;
}

/// Every n-th row, so that at most `most` are left, the last one, and those next to events.
std::vector<std::size_t> thinned(std::span<const double> times, std::size_t most, const std::vector<double>& events) {
  const std::size_t rows = times.size();
  const std::size_t step = std::max<std::size_t>(1, (rows + most - 1) / std::max<std::size_t>(most, 1));
  std::vector<std::size_t> kept;
  for (std::size_t row = 0; row < rows; row += step) kept.push_back(row);
  if (kept.back() + 1 != rows) kept.push_back(rows - 1);
  if (step == 1) return kept;
  const std::vector<std::size_t> more = rows_next_to(events, times, most);
  kept.insert(kept.end(), more.begin(), more.end());
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
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

void write_table(JsonWriter& json, std::string& text, const char* key, const NumberTable& table,
                 const std::vector<std::size_t>& rows, bool precise) {
  json.key(key).begin_object();
  write_names(json, "columns", table.columns());
  std::string numbers;
  (precise ? append_doubles : append_floats)(numbers, table.read(rows));
  json.key("rows");
  raw(json, text, '"' + numbers + '"');
  json.end_object();
}

/// How many contacts are closed at each of some instants, and ten numbers of each: point, normal, force and speed of slip.
void write_contacts(JsonWriter& json, std::string& text, const fs::path& file, const std::vector<double>& times) {
  std::vector<long> counts(times.size(), 0);
  std::vector<double> numbers;
  for_each_contact(file, [&](const ContactCells& row) {
    const auto at = std::lower_bound(times.begin(), times.end(), row.time);
    if (at == times.end() || *at != row.time) return;
    ++counts[static_cast<std::size_t>(at - times.begin())];
    numbers.insert(numbers.end(), row.numbers.begin(), row.numbers.end());
  });
  json.key("contacts").begin_object().key("counts").begin_array();
  for (const long count : counts) json.value(count);
  json.end_array();
  std::string packed;
  append_floats(packed, numbers);
  json.key("rows");
  raw(json, text, '"' + packed + '"');
  json.end_object();
}

std::string document(const fs::path& file) {
  std::string text = read_text_file(file.string(), Links::refuse);
  parse_json(text, file.string());  // or throws
  return text;
}

struct EventLines {
  std::vector<std::string> lines;
  std::vector<double> times;
};
EventLines read_event_lines(const fs::path& file) {
  EventLines events;
  for_each_event(file, [&events](const Value& document, const std::string& line, const std::string&) {
    events.lines.push_back(line);
    const Value::Entry* const time = document.find("time");
    if (const auto at = time != nullptr ? time->value.number() : std::nullopt) events.times.push_back(*at);
  });
  return events;
}

}  // namespace

std::string report_data(const fs::path& directory, const ReportOptions& options) {
  require_result_folder(directory);
  const fs::path model = directory / "model.json", summary = directory / "summary.json";
  if (!is_there(model)) throw_error({"it has no model.json", directory.string(), "was the run killed? run it again"});
  const BodyTable bodies(directory / "bodies.csv");
  std::optional<NumberTable> joints = find_table(directory / "joints.csv");
  const std::optional<NumberTable> energy = find_table(directory / "energy.csv");
  std::size_t count = bodies.times().size();  // a killed run may have written fewer rows of one table than of another
  if (joints) count = std::min(count, joints->times().size());
  if (energy) count = std::min(count, energy->times().size());
  if (count == 0) throw_error({"its tables have no complete row", directory.string(), "the run stopped before it wrote one"});

  const std::size_t width = 7 * bodies.bodies().size();
  const auto affordable = [&](std::size_t columns) { return std::max<std::size_t>(options.most_numbers / columns, 60); };
  std::size_t most = affordable(width + (joints ? joints->columns().size() : 0));
  const bool left_out = joints && most < std::min<std::size_t>(count, 300);
  if (left_out) joints.reset(), most = affordable(width);
  const std::span<const double> all = std::span(bodies.times()).first(count);
  // Times and energies have double precision.
  const std::size_t columns = width + 2 + (joints ? joints->columns().size() : 0) + (energy ? 2 * energy->columns().size() : 0);
  most = std::min(most, useful_rows(all.back() - all.front(), columns, options.plenty));
  const EventLines events = read_event_lines(directory / "events.jsonl");
  std::vector<std::size_t> rows = thinned(all, most, events.times);
  std::vector<double> poses = bodies.poses(rows);
  const auto infinite = std::find_if(poses.begin(), poses.end(), [](double x) { return !std::isfinite(x); });
  rows.resize(static_cast<std::size_t>(infinite - poses.begin()) / width);
  if (rows.empty()) throw_error({"its first row has no finite poses", (directory / "bodies.csv").string(), ""});
  poses.resize(rows.size() * width);

  std::string text;
  JsonWriter json(text);
  json.begin_object().member("format", 1);
  json.member("thinned", rows.size() < count).member("joints_left_out", left_out);
  write_names(json, "bodies", bodies.bodies());
  json.key("kinds");
  write_kinds(json);
  json.key("model");
  raw(json, text, document(model));
  if (const fs::path meshes = directory / "meshes.json"; is_there(meshes)) {
    json.key("meshes");
    raw(json, text, document(meshes));
  }
  json.key("summary");
  raw(json, text, !options.summary.empty() ? options.summary : is_there(summary) ? document(summary) : "null");
  json.key("events").begin_array();
  for (const std::string& line : events.lines) raw(json, text, line);
  json.end_array();
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
  if (const fs::path contacts = directory / "contacts.csv"; is_there(contacts)) write_contacts(json, text, contacts, times);
  json.end_object();

  return json_for_page(text);
}

}  // namespace momentree::io
