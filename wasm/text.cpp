// Names and structure of a world, as JSON.
#include <momentree/scenario/state/joint_json.hpp>
#include <wasm/world.hpp>

namespace momentree::wasm {

namespace {

using io::JsonWriter;

void write_diagnostic(JsonWriter& json, const io::Diagnostic& d) {
  json.begin_object().member("severity", io::word_of(d.severity)).member("line", d.line).member("column", d.column);
  json.member("what", d.what).member("hint", d.hint).end_object();
}

}  // namespace

std::string load_json(const io::ReadResult& result, const std::string& refusal, bool floor) {
  std::string text;
  JsonWriter json(text);
  json.begin_object().key("diagnostics").begin_array();
  for (const io::Diagnostic& d : result.diagnostics) write_diagnostic(json, d);
  if (!refusal.empty()) write_diagnostic(json, {io::Severity::error, "", 0, 0, refusal, "", ""});
  json.end_array();
  if (result.scenario && refusal.empty())
    json.key("scenario").raw(io::scenario_json(*result.scenario, result.scenario->model.gravity(), floor));
  json.end_object();
  return text;
}

}  // namespace momentree::wasm
