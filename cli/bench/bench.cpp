#include <algorithm>
#include <cmath>
#include <cstdio>

#include <cli/bench/models.hpp>
#include <cli/bench/peers.hpp>
#include <cli/bench/tables.hpp>
#include <cli/commands.hpp>
#include <cli/interrupt.hpp>
#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::cli {

namespace {

const char* const peers_hint =
    "Other engines on the same models: --peers BUILD/bench/peers, with programs for those engines that CMake finds\n"
    "(-DMOMENTREE_PEERS=ON; bench/peers/README.md).\n";

void print(const std::string& text) {
  show(stdout, text);
  std::fflush(stdout);
}

std::string nanoseconds(double seconds) { return format("%.1f", seconds * 1e9); }

void print_operations(const Style& style) {
  Table table;
  table.row({"", "additions", "multiplications", "total", "100 bodies", "source"});
  for (const OperationsRow& row : operations_table())
    table.row({row.algorithm, row.additions, row.multiplications, row.total, row.of_100 > 0 ? format("%ld", row.of_100) : "?",
               row.source});
  print(style.heading("Operations per evaluation, n bodies joined by revolute joints") + " (the paper's Table 1)\n" +
        table.text("  ") +
        "  An ellipsis marks what is illegible in print. momentree: divisions count as multiplications, sines and cosines are "
        "excluded.\n\n");
  Table others;
  others.row({"momentree, other chains", "additions", "multiplications", "total", "100 bodies"});
  for (const OperationsRow& row : other_operations())
    others.row({row.algorithm, row.additions, row.multiplications, row.total, format("%ld", row.of_100)});
  print(others.text("  ") + '\n');
}

void print_breaking_chain(const BreakingChain& chain, const Style& style) {
  Table table;
  table.row({"", "before", "after", "the change", "the run"});
  table.row({"paper, 2005", "54.0 µs", "52.3 µs", "0.00 s", "0.64 s"});
  table.row({"here", duration_text(chain.evaluation[0]), duration_text(chain.evaluation[1]), duration_text(chain.change),
             duration_text(chain.whole)});
  print(style.heading("The breaking chain") +
        format(" (the paper's Table 2: time per evaluation, %ld before and %ld after the break; the paper's run includes "
               "evaluations only)\n",
               chain.evaluations[0], chain.evaluations[1]) +
        table.text("  ") + '\n');
}

/// The shortest of several repeats; false if interrupted.
bool print_times(double budget, const Style& style) {
  const auto go_on = [] { return !InterruptGuard::interrupted(); };
  Table evaluations;
  evaluations.row({"", "bodies", "DoFs", "evaluation", "ns per body"});
  evaluation_times(budget, [&](const EvaluationRow& row) {
    evaluations.row({row.model, format("%d", row.bodies), format("%d", row.dofs), duration_text(row.seconds),
                     nanoseconds(row.seconds / row.bodies)});
    return go_on();
  });
  if (!go_on()) return false;
  print(style.heading("Time of an evaluation") +
        " (one core, double precision; shortest of many, each at different coordinates, joint forces included)\n" +
        evaluations.text("  ") + '\n');
  Table generated;
  generated.row({"", "bodies", "operations", "generated", "ns per body", "generated", "faster"});
  const std::string none = generated_times(budget, [&](const GeneratedRow& row) {
    generated.row({row.model, format("%d", row.bodies), format("%ld", row.operations[0]), format("%ld", row.operations[1]),
                   nanoseconds(row.seconds[0] / row.bodies), nanoseconds(row.seconds[1] / row.bodies),
                   format("%.2f times", row.seconds[0] / row.seconds[1])});
    return go_on();
  });
  if (!go_on()) return false;
  print(style.heading("Generated code") + " (the rates alone, generated code and kernels measured alternately)\n" +
        (none.empty() ? generated.text("  ") : "  " + none + '\n') + '\n');
  Table changes;
  changes.row({"", "", "bodies", "ns"});
  change_times(budget, [&](const ChangeRow& row) {
    changes.row({row.change, row.model, format("%d", row.bodies), format("%.0f", row.seconds * 1e9)});
    return go_on();
  });
  if (!go_on()) return false;
  print(style.heading("Time of a change") + " (by itself, without the evaluations before and after it)\n" + changes.text("  ") +
        '\n');
  return true;
}

void print_large_worlds(const std::vector<LargeRow>& rows, const Style& style) {
  const auto bytes = [](double value) { return value > 0 ? format("%.0f", value) : std::string("?"); };
  Table table;
  table.row({"revolute chain in 3D", "bodies", "ns per body", "bytes per body", "with motions"});
  for (const LargeRow& row : rows)
    table.row(
        {row.model, format("%d", row.bodies), nanoseconds(row.seconds / row.bodies), bytes(row.bytes[0]), bytes(row.bytes[1])});
  print(style.heading("Large worlds") +
        " (one evaluation, one core; resident memory per body of Tree, State and Work, without model and names: after\n"
        "evaluations as in a step, and after one for changes and results, which stores the motions of bodies)\n" +
        table.text("  ") + '\n');
}

void write(io::JsonWriter& json, const OperationsRow& row) {
  json.begin_object().member("algorithm", row.algorithm).member("additions", row.additions);
  json.member("multiplications", row.multiplications).member("total", row.total).key("of_100");
  row.of_100 > 0 ? json.value(row.of_100) : json.null();
  json.member("source", row.source).end_object();
}

/// Prints one document; false if interrupted.
bool print_json(const BenchOptions& options, const std::vector<LargeRow>& large, const std::vector<std::string>& peers) {
  std::string text;
  io::JsonWriter json(text, 2);
  const auto go_on = [] { return !InterruptGuard::interrupted(); };
  json.begin_object().key("operations").begin_array();
  for (const OperationsRow& row : operations_table()) write(json, row);
  json.end_array().key("operations_of_other_chains").begin_array();
  for (const OperationsRow& row : other_operations()) write(json, row);
  json.end_array();

  const BreakingChain chain = breaking_chain(options.repeats);
  const double evaluation[] = {chain.evaluation[0] * 1e9, chain.evaluation[1] * 1e9};
  json.key("breaking_chain").begin_object();
  json.key("evaluations").begin_array().value(chain.evaluations[0]).value(chain.evaluations[1]).end_array();
  json.member("evaluation_ns", std::span<const double>(evaluation)).member("change_ns", chain.change * 1e9);
  json.member("run_s", chain.whole).end_object();
  if (!go_on()) return false;

  json.key("evaluations").begin_array();
  evaluation_times(options.budget, [&](const EvaluationRow& row) {
    json.begin_object().member("model", row.model).member("bodies", row.bodies).member("freedoms", row.dofs);
    json.member("ns", row.seconds * 1e9).member("ns_per_body", row.seconds * 1e9 / row.bodies).member("error", row.error);
    json.end_object();
    return go_on();
  });
  json.end_array().key("generated").begin_array();
  generated_times(options.budget, [&](const GeneratedRow& row) {
    json.begin_object().member("model", row.model).member("bodies", row.bodies);
    json.key("operations").begin_array().value(row.operations[0]).value(row.operations[1]).end_array();
    const double ns[] = {row.seconds[0] * 1e9, row.seconds[1] * 1e9};
    json.member("ns", std::span<const double>(ns)).member("error", row.error).end_object();
    return go_on();
  });
  json.end_array().key("changes").begin_array();
  change_times(options.budget, [&](const ChangeRow& row) {
    json.begin_object().member("change", row.change).member("model", row.model).member("bodies", row.bodies);
    json.member("ns", row.seconds * 1e9).end_object();
    return go_on();
  });
  json.end_array().key("large_worlds").begin_array();
  const auto bytes = [&](const char* key, double value) {
    json.key(key);
    value > 0 ? json.value(value) : json.null();
  };
  for (const LargeRow& row : large) {
    json.begin_object().member("model", row.model).member("bodies", row.bodies);
    json.member("ns_per_body", row.seconds * 1e9 / row.bodies).member("error", row.error);
    bytes("bytes_per_body", row.bytes[0]);
    bytes("bytes_per_body_with_motions", row.bytes[1]);
    json.end_object();
  }
  json.end_array();
  if (!peers.empty()) write_peers(json, measure_peers(peers, {}));
  json.end_object();
  if (go_on()) print(text + '\n');
  return go_on();
}

int measure(const BenchOptions& options, const std::vector<std::string>& peers) {
  const InterruptGuard guard;
  std::vector<LargeRow> large;  // first, before freed memory is available for reuse
  large_worlds(options.bodies, [&](const LargeRow& row) {
    large.push_back(row);
    return !InterruptGuard::interrupted();
  });
  if (InterruptGuard::interrupted()) return interrupted;
  if (options.json) return print_json(options, large, peers) ? done : interrupted;
  const Style style = Style::of_output();
  print_operations(style);
  print_breaking_chain(breaking_chain(options.repeats), style);
  if (InterruptGuard::interrupted() || !print_times(options.budget, style)) return interrupted;
  print_large_worlds(large, style);
  if (peers.empty()) return print(peers_hint), done;
  const std::vector<PeerRow> rows = measure_peers(peers, {});
  if (InterruptGuard::interrupted()) return interrupted;
  print(style.heading("Other engines") +
        " (grounded revolute chains and a floating humanoid, with gravity: from positions and velocities (momentree: momenta) to "
        "what a step "
        "needs; ns per body, and the ratio to the first row; all accelerations checked)\n" +
        peers_table(rows) + '\n');
  return done;
}

}  // namespace

int bench(const BenchOptions& options) {
  std::vector<std::string> peers;
  try {
    if (!options.peers.empty()) peers = peer_programs(options.peers);
  } catch (const Error& error) {
    show(stderr, "momentree bench: " + error.message() + '\n');
    return bad_input;
  }
  if (!options.models.empty()) return bench_models(options, peers);
  try {
    return measure(options, peers);
  } catch (const Error& error) {  // not the user's mistake
    show(stderr, "momentree bench: " + error.message() + '\n');
    return failed;
  }
}

}  // namespace momentree::cli
