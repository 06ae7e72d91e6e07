// Compares two results, and says where they differ first.
#include <cstdio>

#include <cli/commands.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/results/compare/compare.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::cli {

namespace {

const char* kind_name(io::Difference::Kind kind) {
  switch (kind) {
    case io::Difference::Kind::model: return "model";
    case io::Difference::Kind::value: return "value";
    case io::Difference::Kind::rows: return "rows";
    case io::Difference::Kind::longer: return "longer";
    case io::Difference::Kind::document: return "document";
  }
  return "";
}

std::string comparison_json(const io::Comparison& comparison, double tolerance) {
  std::string text;
  io::JsonWriter json(text, 2);
  const auto optional = [&json](const char* name, const std::string& value) {
    json.key(name);
    value.empty() ? json.null() : json.value(value);
  };
  json.begin_object().member("equal", comparison.equal()).member("tolerance", tolerance);
  json.member("rows", static_cast<long>(comparison.rows)).member("events", static_cast<long>(comparison.events));
  json.key("differences").begin_array();
  for (const io::Difference& d : comparison.differences) {
    json.begin_object().member("kind", kind_name(d.kind)).member("file", d.file);
    json.key("row");
    d.row ? json.value(static_cast<long>(*d.row)) : json.null();
    json.key("time");
    d.time ? json.value(*d.time) : json.null();
    optional("name", d.name), optional("column", d.column), optional("first", d.one), optional("second", d.other);
    json.member("what", d.what).end_object();
  }
  json.end_array().end_object();
  return text + '\n';
}

std::string difference_text(const io::Difference& d) {
  std::string text = d.file;
  if (d.row) text += format(d.file == "events.jsonl" ? ", event %zu" : ", row %zu", *d.row);
  if (d.time) text += format(", t = %.9g s", *d.time);
  return text + ": " + printable(d.what) + '\n';
}

}  // namespace

int compare(const CompareOptions& options) {
  const io::Comparison comparison = io::compare_results(options.one, options.other, options.tolerance);
  const int code = comparison.equal() ? done : failed;
  if (options.json) return std::fputs(comparison_json(comparison, options.tolerance).c_str(), stdout), code;
  if (comparison.equal()) {
    show(stdout, "The runs are equal" + (options.tolerance > 0 ? format(" to within %g", options.tolerance) : "") + ": " +
                     count_text(static_cast<long>(comparison.rows), "row", "rows") + ", " +
                     count_text(static_cast<long>(comparison.events), "event", "events") + '\n');
    return code;
  }
  for (const io::Difference& difference : comparison.differences) show(stdout, difference_text(difference));
  return code;
}

}  // namespace momentree::cli
