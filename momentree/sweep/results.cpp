#include <momentree/sweep/results.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/text/number_text.hpp>

namespace momentree::sweep {

namespace {

// Quoted as in RFC 4180 where that is necessary.
void append_field(std::string& text, const std::string& field) {
  if (field.find_first_of(",\"\r\n") == std::string::npos) {
    text += field;
    return;
  }
  text += '"';
  for (const char c : field) text.append(c == '"' ? 2 : 1, c);
  text += '"';
}

// An argument for a shell.
std::string shell_word(const std::string& text) {
  constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+=:@%";
  if (!text.empty() && text.find_first_not_of(plain) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + '\'';
}

}  // namespace

void for_each_row(const Sweep& sweep, const Journal& journal, const std::function<bool(const Row&)>& visit) {
  std::vector<Journal::Entry> entries = journal.entries();
  std::sort(entries.begin(), entries.end(),
            [](const Journal::Entry& a, const Journal::Entry& b) { return a.chunk.first < b.chunk.first; });
  Row row;
  row.values.resize(sweep.plan->size());
  for (const Journal::Entry& entry : entries) {
    const std::string bytes = journal.read(entry);
    ResultReader reader(bytes, sweep.measures.size());
    for (row.world = entry.chunk.first; reader.next(row.result); ++row.world) {
      sweep.plan->values(row.world, row.values);
      if (!visit(row)) return;
    }
  }
}

std::string replay_command(const Sweep& sweep, std::uint64_t world) {
  return "momentree sweep " + shell_word(sweep.path) + " --world " + std::to_string(world);
}

std::string run_command(const Sweep& sweep, std::uint64_t world) {
  std::string command = "momentree run " + shell_word(sweep.scenario->path);
  for (const std::string& each : sweep.overrides(world)) command += " --set " + shell_word(each);
  return command;
}

std::string status_of(const WorldResult& result) { return result.done() ? "done" : "failed: " + result.failure; }

void RowWriter::csv_header(std::string& text) const {
  text += "world";
  for (const ParameterColumn& column : columns_) {
    text += ',';
    append_field(text, column.name);
  }
  for (const Measure& measure : sweep_.measures) {
    text += ',';
    append_field(text, measure.name);
  }
  text += ",status\n";
}

void RowWriter::csv(const Row& row, std::string& text) const {
  text += std::to_string(row.world);
  for (const ParameterColumn& column : columns_) {
    text += ',';
    append_field(text, parameter_text(column, row.values));
  }
  for (std::size_t m = 0; m < sweep_.measures.size(); ++m) {
    text += ',';
    const double x = row.result.done() ? row.result.measures[m] : NAN;
    if (std::isnan(x)) continue;
    if (sweep_.measures[m].is_flag())
      text += x != 0 ? "true" : "false";
    else
      io::append_number(text, x);
  }
  text += ',';
  append_field(text, status_of(row.result));
  text += '\n';
}

void RowWriter::varied_json(const Row& row, io::JsonWriter& json) const {
  for (const ParameterColumn& column : columns_) {
    if (column.is_text)
      json.member(column.name, parameter_text(column, row.values));
    else
      json.member(column.name, parameter_number(column, row.values));
  }
}

void RowWriter::json(const Row& row, std::string& text) const {
  io::JsonWriter json(text);
  json.begin_object().key("world").value(static_cast<long>(row.world));
  varied_json(row, json);
  for (std::size_t m = 0; m < sweep_.measures.size(); ++m) {
    json.key(sweep_.measures[m].name);
    const double x = row.result.done() ? row.result.measures[m] : NAN;
    if (!std::isnan(x) && sweep_.measures[m].is_flag())
      json.value(x != 0);
    else
      json.value(x);
  }
  json.member("status", status_of(row.result)).end_object();
  text += '\n';
}

void RowWriter::failure(const Row& row, std::string& text) const {
  io::JsonWriter json(text);
  json.begin_object().key("world").value(static_cast<long>(row.world));
  json.member("why", row.result.failure);
  json.key("values").begin_object();
  varied_json(row, json);
  json.end_object().member("replay", replay_command(sweep_, row.world)).end_object();
  text += '\n';
}

}  // namespace momentree::sweep
