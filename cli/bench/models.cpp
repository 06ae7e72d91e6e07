// `momentree bench MODEL…`: times of a user's own models on this machine, and in other engines.
#include <cstdio>
#include <optional>

#include <cli/bench/models.hpp>
#include <cli/bench/own.hpp>
#include <cli/bench/peer_links.hpp>
#include <cli/bench/peers.hpp>
#include <cli/commands.hpp>
#include <cli/input.hpp>
#include <cli/interrupt.hpp>
#include <cli/record.hpp>
#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/text/files/text_file.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::cli {

namespace {

std::string time_or_dash(double seconds) { return seconds > 0 ? duration_text(seconds) : "–"; }

void print_own(const std::vector<OwnRow>& rows, const Style& style) {
  Table times;
  times.row({"", "bodies", "DoFs", "evaluation", "accelerations", "in a batch", "kernels", "generated", "break", "lock"});
  std::string notes;
  for (const OwnRow& row : rows) {
    times.row({row.model, format("%d", row.bodies), format("%d", row.dofs), duration_text(row.evaluation),
               duration_text(row.accelerations), time_or_dash(row.batch), time_or_dash(row.kernels), time_or_dash(row.generated),
               time_or_dash(row.break_joint), time_or_dash(row.lock_joint)});
    if (!row.batch_message.empty()) notes += "  " + row.model + ": " + row.batch_message + '\n';
    if (!row.broken.empty()) notes += "  " + row.model + ": the joint broken is " + row.broken;
    if (!row.broken.empty()) notes += row.locked.empty() ? "\n" : ", the joint locked is " + row.locked + '\n';
  }
  const std::string text =
      style.heading("Your models") +
      " (one core, double precision; shortest of many, each at different coordinates. Evaluation: rates with joint forces; with\n"
      "accelerations and all joint wrenches; in one of 64 worlds of a batch; the rates alone, by the kernels and by "
      "generated code;\na change by itself, without the evaluations before and after it)\n" +
      times.text("  ") + notes + '\n';
  show(stdout, text);
  std::fflush(stdout);
}

void write_own(io::JsonWriter& json, const std::vector<OwnRow>& rows) {
  const auto nanoseconds = [&](const char* key, double seconds) {
    json.key(key);
    seconds > 0 ? json.value(seconds * 1e9) : json.null();
  };
  json.key("models").begin_array();
  for (const OwnRow& row : rows) {
    json.begin_object().member("model", row.model).member("bodies", row.bodies).member("freedoms", row.dofs);
    nanoseconds("evaluation_ns", row.evaluation);
    nanoseconds("accelerations_ns", row.accelerations);
    nanoseconds("batch_ns", row.batch);
    nanoseconds("kernels_ns", row.kernels);
    nanoseconds("generated_ns", row.generated);
    json.member("broken", row.broken);
    nanoseconds("break_ns", row.break_joint);
    json.member("locked", row.locked);
    nanoseconds("lock_ns", row.lock_joint);
    json.member("error", row.error).end_object();
  }
  json.end_array();
}

int measure(const BenchOptions& options, const std::vector<io::Scenario>& scenarios, const std::vector<std::string>& peers,
            const std::vector<std::string>& files) {
  const InterruptGuard guard;
  const KernelCache kernels({.most_operations = 20000});
  std::vector<OwnRow> rows;
  for (const io::Scenario& scenario : scenarios) {
    if (InterruptGuard::interrupted()) return interrupted;
    rows.push_back(own_times(scenario.name, scenario.model, kernels, options.budget));
  }
  const Style style = Style::of_output();
  if (!options.json) print_own(rows, style);
  const std::vector<PeerRow> others = measure_peers(peers, files);
  if (InterruptGuard::interrupted()) return interrupted;
  std::string text;
  if (options.json) {
    io::JsonWriter json(text, 2);
    json.begin_object();
    write_own(json, rows);
    if (!peers.empty()) write_peers(json, others);
    json.end_object();
  } else if (!peers.empty()) {
    text = style.heading("Other engines") +
           " (with gravity, without joint forces and armatures: from positions and velocities (momentree: momenta) to\n"
           "what a step needs; ns per moving body, and the ratio to the first row; all accelerations checked)\n" +
           peers_table(others);
  }
  if (text.empty()) return done;
  if (options.json)
    std::fputs((text + '\n').c_str(), stdout);
  else
    show(stdout, text + '\n');
  return done;
}

}  // namespace

int bench_models(const BenchOptions& options, const std::vector<std::string>& peers) {
  std::vector<io::Scenario> scenarios;
  std::optional<TemporaryFolder> folder;  // for the programs of other engines
  std::vector<std::string> files;
  if (!peers.empty()) folder.emplace();
  for (const std::string& path : options.models) {  // all are read before the first is measured
    std::shared_ptr<const io::Scenario> scenario = load(path, {}, Notes::counted, io::Severity::error);
    if (!scenario) return bad_input;
    if (compile(scenario->model).nv() == 0) throw_error({"nothing in it moves: there is nothing to measure", path, ""});
    if (const auto& loops = scenario->model.loops(); !loops.empty())
      throw_error({"closed loops are not measured: joint " + io::in_quotes(loops.front().name) + " closes one", path,
                   "leave it out, or measure another model"});
    if (!peers.empty()) {
      files.push_back(folder->file(std::to_string(files.size())));
      try {
        io::write_text_file(files.back(), peer_links(scenario->name, scenario->model));
      } catch (const Error& error) {
        throw_error({error.problem, error.where.empty() ? path : error.where, error.hint});
      }
    }
    scenarios.push_back(*scenario);
  }
  try {
    return measure(options, scenarios, peers, files);
  } catch (const Error& error) {  // not the user's mistake
    show(stderr, "momentree bench: " + error.message() + '\n');
    return failed;
  }
}

}  // namespace momentree::cli
