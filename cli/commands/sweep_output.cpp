#include <cli/commands/sweep_output.hpp>

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <set>

#include <cli/commands/sweep_hdf5.hpp>
#include <cli/interrupt.hpp>
#include <cli/page.hpp>
#include <cli/record.hpp>
#include <momentree/base/error.hpp>
#include <momentree/results/report/page.hpp>
#include <momentree/sweep/read_results.hpp>
#include <momentree/sweep/scenario_worlds.hpp>
#include <momentree/text/files/text_file.hpp>
#include <momentree/text/json.hpp>

namespace momentree::cli {

namespace {

namespace fs = std::filesystem;
using sweep::Journal;

constexpr const char* journal_name = io::journal_file;
constexpr std::size_t animated_ends = 3;  // worlds with a page of their own, at each end of each measure

sweep::JournalIdentity identity_of(const sweep::Sweep& sweep, sweep::Lanes lanes) {
  return {sweep::program_text(lanes), sweep.hash, sweep.plan_hash, sweep.worlds(), sweep.measures.size()};
}

// Why a journal does not belong to the sweep; empty if it does.
std::string difference(const sweep::JournalIdentity& found, const sweep::JournalIdentity& wanted) {
  if (found == wanted) return "";
  if (found.worlds != wanted.worlds || found.measures != wanted.measures)
    return "this folder has the unfinished results of another sweep, with " + std::to_string(found.worlds) + " worlds and " +
           std::to_string(found.measures) + " measures";
  if (found.plan != wanted.plan)
    return "the values of worlds have changed since these unfinished results: [vary], [[correlated]], the seed or the number of "
           "worlds";
  if (found.hash != wanted.hash)
    return "this folder has the unfinished results of another sweep, or of one that has been changed";
  return "this folder has unfinished results of version " + found.version + ", and this is version " + wanted.version;
}

// `accepted_changes` of sweep.json.
std::vector<sweep::FormerIdentity> former_of(const std::string& summary) {
  const Value document = io::parse_json(summary, "sweep.json");
  const Value::Entry* const entries = document.find("accepted_changes");
  std::vector<sweep::FormerIdentity> all;
  if (entries == nullptr || entries->value.array() == nullptr) return all;
  for (const Value& each : *entries->value.array()) {
    const Value::Entry *const version = each.find("version"), *const hash = each.find("hash");
    if (version != nullptr && version->value.string() && hash != nullptr && hash->value.string())
      all.push_back({*version->value.string(), *hash->value.string()});
  }
  return all;
}

std::vector<std::string> files_of(const sweep::Sweep& sweep, const SweepOptions& options) {
  std::vector<std::string> files = {"worlds.csv", "failures.jsonl", "sweep.json"};
  if (sweep.json_lines) files.emplace_back("worlds.jsonl");
  if (options.report) files.emplace_back("report.html");
  return files;
}

}  // namespace

bool is_one_file(const std::string& destination) { return destination.ends_with(".h5"); }

std::string complete_summary(const std::string& out) {
  std::error_code ignored;
  if (is_one_file(out)) return fs::is_regular_file(out, ignored) ? summary_in(out) : "";
  const fs::path file = fs::path(out) / "sweep.json";
  return fs::is_regular_file(file, ignored) ? io::read_text_file(file.string()) : "";
}

std::string sweep_destination(const sweep::Sweep& sweep, const SweepOptions& options) {
  if (!options.out.empty()) return options.out;
  return sweep.output.empty() ? "results/" + sweep.name : sweep.output;
}

bool is_complete_sweep(const sweep::Sweep& sweep, const std::string& out) {
  try {
    const std::string text = complete_summary(out);
    if (text.empty()) return false;
    const Value document = io::parse_json(text, out);
    const Value::Entry* const hash = document.find("hash");
    const Value::Entry* const program = document.find("program");
    const Value::Entry* const version = program != nullptr ? program->value.find("version") : nullptr;
    if (hash == nullptr || version == nullptr || !hash->value.string() || !version->value.string()) return false;
    return *hash->value.string() == sweep.hash && *version->value.string() == MOMENTREE_VERSION;
  } catch (const Error&) {  // not a document of momentree
    return false;
  }
}

bool needs_report(const std::string& out, const SweepOptions& options) {
  std::error_code ignored;
  return options.report && !fs::exists(fs::path(out) / "report.html", ignored);
}

SweepOutput::SweepOutput(const sweep::Sweep& sweep, sweep::Lanes lanes, const SweepOptions& options)
    : sweep_(sweep), out_(sweep_destination(sweep, options)) {
  std::error_code ignored;
  if (in_one_file()) {
    io::require_hdf5();
    if (fs::is_directory(out_, ignored)) throw_error({"there is a folder of that name already", out_, "name a file with --out"});
    require_replaceable(out_);
    if (options.report) throw_error({"--report needs a folder for the results, not a file", out_, "name a folder with --out"});
  }
  folder_.emplace(in_one_file() ? out_ + ".sweep" : out_, in_one_file() ? std::vector<std::string>() : files_of(sweep, options),
                  true, io::ResultDirectory::Earlier::kept);
  const sweep::JournalIdentity wanted = identity_of(sweep, lanes);
  if (folder_->has(journal_name) && !options.restart) {
    journal_.emplace(Journal::open((folder_->working() / journal_name).string()));
    const std::string why = difference(journal_->identity(), wanted);
    const sweep::JournalIdentity& found = journal_->identity();
    const bool same_form = found.worlds == wanted.worlds && found.measures == wanted.measures && found.plan == wanted.plan;
    if (!why.empty() && !(options.accept_changes && same_form))
      throw_error({why, folder_->working().string(),
                   std::string("--restart discards them") + (same_form ? ", and --accept-changes continues from them" : "")});
    for (const Journal::Entry& entry : journal_->entries()) found_ += entry.chunk.count;
    try_table();
    if (!why.empty()) journal_->accept(wanted);
    folder_->keep();
    return;
  }
  if (options.resume && !options.restart) {
    if (in_one_file() && fs::exists(out_, ignored))
      throw_error({"this file has the complete results of another sweep, or of one that has been changed", out_,
                   "leave out --resume to replace it, or name another file with --out"});
    if (!in_one_file() && is_complete_sweep(sweep_, out_)) {
      restore(wanted);
      return;
    }
    if (fs::exists(fs::path(out_) / "sweep.json", ignored))
      throw_error({"this folder has the complete results of another sweep, or of one that has been changed", out_,
                   "leave out --resume to replace them, or name another folder with --out"});
  }
  if (folder_->has(io::checkpoint_file) && !options.restart)
    throw_error({"this folder has the unfinished results of a run", folder_->working().string(),
                 "continue it with momentree run --resume, name another folder with --out, or discard it with --restart"});
  try_table();
  folder_->clear();
  journal_.emplace(Journal::create(folder_->file(journal_name), wanted));
  folder_->keep();
}

// Makes the journal of a complete sweep again from its table, so that the sweep can be published with a report.
void SweepOutput::restore(const sweep::JournalIdentity& wanted) {
  const std::string table = (fs::path(out_) / "worlds.csv").string(), summary = complete_summary(out_);
  const auto refuse = [&table] {
    throw_error(
        {"this table has been changed, or the version of momentree that wrote it was another one: no report can be made of it",
         table, "leave out --resume to compute all worlds again"});
  };
  std::vector<sweep::JournalIdentity> identities;
  for (const sweep::FormerIdentity& each : former_of(summary)) {
    identities.push_back(wanted);
    identities.back().version = each.version, identities.back().hash = each.hash;
  }
  identities.push_back(wanted);
  folder_->clear();
  journal_.emplace(Journal::create(folder_->file(journal_name), identities.front()));
  for (std::size_t i = 1; i < identities.size(); ++i) journal_->accept(identities[i]);
  sweep::Chunk chunk;
  std::string encoded;
  const auto append = [&] {
    if (chunk.count > 0) journal_->append(chunk, encoded);
    chunk = {chunk.first + chunk.count, 0};
    encoded.clear();
  };
  const auto take = [&](const sweep::WorldResult& result) {
    encode(result, encoded);
    if (++chunk.count == 4096) append();
  };
  if (!read_csv(sweep_, io::read_text_file(table), take)) refuse();
  append();
  sweep::SweepSummary again(sweep_);
  again.set_former(journal_->former());
  for_each_row(sweep_, *journal_, [&](const sweep::Row& row) {
    again.add(row);
    return true;
  });
  if (again.json() != summary) refuse();
  found_ = sweep_.worlds();
  folder_->keep();
}

// A name that HDF5 cannot store is found before the first world.
void SweepOutput::try_table() {
  if (in_one_file()) SweepTable(sweep_, (folder_->working() / "names.h5").string());
}

void SweepOutput::write_tables() {
  for (const char* name : {"worlds.csv", "failures.jsonl", "worlds.jsonl"}) folder_->remove(name);  // of a run that was killed
  const sweep::RowWriter writer(sweep_);
  io::TextFile worlds(folder_->file("worlds.csv")), failures(folder_->file("failures.jsonl"));
  std::optional<io::TextFile> lines;
  if (sweep_.json_lines) lines.emplace(folder_->file("worlds.jsonl"));
  writer.csv_header(worlds.text());
  for_each_row(sweep_, *journal_, [&](const sweep::Row& row) {
    summary_->add(row);
    writer.csv(row, worlds.text());
    worlds.settle();
    if (lines) {
      writer.json(row, lines->text());
      lines->settle();
    }
    if (!row.result.done()) {
      writer.failure(row, failures.text());
      failures.settle();
    }
    return true;
  });
  worlds.close(true);
  failures.close(true);
  if (lines) lines->close(true);
  folder_->write("sweep.json", summary_->json());
}

void SweepOutput::write_hdf5() {
  const std::string path = folder_->file("results.h5");
  folder_->remove("results.h5");
  SweepTable table(sweep_, path);
  for_each_row(sweep_, *journal_, [&](const sweep::Row& row) {
    summary_->add(row);
    table.add(row);
    return true;
  });
  table.finish(summary_->json());
}

// The worst worlds are run again, each with a page that shows its motion. False: interrupted.
bool SweepOutput::write_report(std::vector<std::string>& warnings) {
  std::set<std::uint64_t> wanted;
  for (const sweep::Worst& worst : summary_->worst(animated_ends))
    for (const sweep::Extreme& each : worst.worlds) wanted.insert(each.world);
  std::vector<std::uint64_t> animated;
  for (const std::uint64_t world : wanted) {
    if (InterruptGuard::interrupted()) return false;
    std::string page, why;
    try {
      page = page_of(world);
    } catch (const Error& error) {
      why = error.message();
    }
    if (InterruptGuard::interrupted()) return false;
    if (page.empty()) {
      warnings.push_back(sweep_.path + ": warning: the report has no animation of world " + std::to_string(world) +
                         (why.empty() ? ": it could not be run again" : ": " + why));
      continue;
    }
    folder_->write(sweep::page_of_world(world).c_str(), page);
    animated.push_back(world);
  }
  folder_->write("report.html", io::sweep_page(sweep_html(), summary_->report(animated)));
  return true;
}

// Empty, with a message, if the run failed.
std::string SweepOutput::page_of(std::uint64_t world) const {
  io::ReadResult read = io::read_scenario_again(*sweep_.scenario, sweep_.overrides(world));
  if (!read.scenario) return "";
  const TemporaryFolder scratch;
  sweep::Observation observation(sweep_.measures);
  const Recorded recorded = record(*read.scenario, scratch.result(), Purpose::report, [&](Simulation& simulation, double until) {
    return run_world(simulation, until, sweep_.stop, observation);
  });
  return recorded.code == done ? report_of(recorded.folder) : "";
}

std::optional<std::vector<std::string>> SweepOutput::publish(bool report) {
  journal_->flush();
  summary_.emplace(sweep_);
  summary_->set_former(journal_->former());
  if (in_one_file()) {
    write_hdf5();
    const std::string file = (folder_->working() / "results.h5").string();
    require_replaceable(out_);  // it may be new
    std::error_code error;
    fs::rename(file, out_, error);
    if (error) io::fail_with_reason("cannot move the result to its destination", out_, error);
    const fs::path above = fs::path(out_).parent_path();
    io::sync_folder(above.empty() ? "." : above);
    folder_->remove_all();
    return std::vector<std::string>();
  }
  write_tables();
  std::vector<std::string> warnings;
  if (report && !write_report(warnings)) return std::nullopt;
  for (std::string& warning : folder_->publish()) warnings.push_back(std::move(warning));
  ::unlink((fs::path(out_) / journal_name).c_str());  // last: until here the results could be made again from it
  return warnings;
}

}  // namespace momentree::cli
