#include <algorithm>
#include <charconv>
#include <cstdio>
#include <optional>

#include <cli/commands.hpp>
#include <cli/input.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/sweep/plan/read_sweep.hpp>
#include <momentree/text/diagnostic_json.hpp>
#include <momentree/text/files/input_file.hpp>

namespace momentree::cli {

namespace {

/// The findings for one file.
struct Checked {
  std::string file;
  std::vector<io::Diagnostic> diagnostics;
  struct Counts {
    long mechanisms = 0, bodies = 0, dofs = 0, events = 0;
  };
  std::optional<Counts> counts;           ///< if there is no error
  std::optional<std::uint64_t> worlds{};  ///< of a sweep
};

// The place of a thrown error is `file:line:column`, as far as it is known.
io::Diagnostic diagnostic_of(const Error& error, const std::string& file) {
  io::Diagnostic found{io::Severity::error, file, 0, 0, error.problem, error.hint, ""};
  std::string where = error.where;
  int numbers[2] = {0, 0}, count = 0;  // from the end
  while (count < 2) {
    const std::size_t colon = where.rfind(':');
    int number = 0;
    if (colon == std::string::npos || colon + 1 == where.size()) break;
    const auto [end, failed] = std::from_chars(where.data() + colon + 1, where.data() + where.size(), number);
    if (failed != std::errc() || end != where.data() + where.size()) break;
    numbers[count++] = number;
    where.resize(colon);
  }
  if (count > 0) found.line = numbers[count - 1], found.column = count == 2 ? numbers[0] : 0;
  if (count > 0 || (!where.empty() && where.find_first_of("./") != std::string::npos))
    found.file = where;
  else if (!where.empty())
    found.what = where + ": " + error.problem;  // a body or a joint
  return found;
}

Checked::Counts counts_of(const World& world, const io::Scenario& scenario) {
  return {static_cast<long>(world.mechanisms().size()), world.model().size(), world.tree().nv(),
          static_cast<long>(scenario.events.size())};
}

bool is_sweep_file(const std::string& file) {
  constexpr std::uintmax_t largest = 64u << 20;
  std::string text;
  io::Unreadable ignored;
  return file.ends_with(".toml") && io::read_whole_file(file, "sweep", largest, text, ignored) && sweep::is_sweep(text);
}

// Some errors in a file that reads well appear only when it is compiled: state documents that do not fit, events that are too
// early.
Checked check_one(const std::string& file, Notes notes) {
  Checked checked{is_standard_input(file) ? standard_input : file, {}, {}};
  try {
    if (is_sweep_file(file)) {
      sweep::ReadSweep read = sweep::read_sweep(file);
      checked.diagnostics = std::move(read.diagnostics);
      if (!read.sweep) return checked;
      checked.worlds = read.sweep->worlds();
      const io::Scenario& scenario = *read.sweep->scenario;
      checked.counts = counts_of(io::Session(read.sweep->scenario).simulation().world(), scenario);
      return checked;
    }
    io::ReadResult result = read_input(file);
    if (notes == Notes::counted) count_notes(result);
    checked.diagnostics = std::move(result.diagnostics);
    if (!result.scenario) return checked;
    io::Session session(*result.scenario);
    for (io::Diagnostic& warning : session.schedule()) checked.diagnostics.push_back(std::move(warning));
    checked.counts = counts_of(session.simulation().world(), *result.scenario);
  } catch (const io::InputError& error) {  // a state document
    checked.diagnostics.insert(checked.diagnostics.end(), error.diagnostics.begin(), error.diagnostics.end());
  } catch (const Error& error) {
    checked.diagnostics.push_back(diagnostic_of(error, checked.file));
  }
  return checked;
}

void print(const Checked& checked) {
  show(stdout, io::rendered(checked.diagnostics));
  if (!checked.counts) return;
  const Checked::Counts& n = *checked.counts;
  show(stdout, printable(checked.file) + ": ok: " + count_text(n.mechanisms, "mechanism", "mechanisms") + ", " +
                   count_text(n.bodies, "body", "bodies") + ", " + count_text(n.dofs, "degree of freedom", "degrees of freedom") +
                   ", " + count_text(n.events, "event", "events") +
                   (checked.worlds ? ", in " + count_text(static_cast<long>(*checked.worlds), "world", "worlds") : "") + '\n');
}

void write(io::JsonWriter& json, const Checked& checked) {
  json.begin_object().member("file", checked.file).member("ok", checked.counts.has_value());
  if (checked.counts) {
    const Checked::Counts& n = *checked.counts;
    json.member("mechanisms", n.mechanisms).member("bodies", n.bodies).member("freedoms", n.dofs).member("events", n.events);
    if (checked.worlds) json.member("worlds", static_cast<long>(*checked.worlds));
  }
  json.key("diagnostics").begin_array();
  for (const io::Diagnostic& each : checked.diagnostics) io::write_diagnostic(json, each);
  json.end_array().end_object();
}

}  // namespace

int check(const CheckOptions& options) {
  int code = done;
  long errors = 0, warnings = 0;
  std::string text;
  io::JsonWriter json(text, 4);
  json.begin_object().key("files").begin_array();
  for (const std::string& file : options.files) {
    const Checked checked = check_one(file, notes_of(options.verbose || options.json));
    if (!checked.counts) code = bad_input;
    for (const io::Diagnostic& each : checked.diagnostics) {
      errors += each.severity == io::Severity::error;
      warnings += each.severity == io::Severity::warning;
    }
    if (options.json)
      write(json, checked);
    else
      print(checked);
  }
  json.end_array().member("errors", errors).member("warnings", warnings).end_object();
  if (options.json) std::printf("%s\n", text.c_str());
  return code;
}

}  // namespace momentree::cli
