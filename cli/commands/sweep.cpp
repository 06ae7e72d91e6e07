#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include <cli/commands.hpp>
#include <cli/commands/sweep_output.hpp>
#include <cli/input.hpp>
#include <cli/interrupt.hpp>
#include <cli/progress.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/base/error.hpp>
#include <momentree/sweep/machines/coordinator.hpp>
#include <momentree/sweep/machines/distribute.hpp>
#include <momentree/sweep/machines/launch.hpp>
#include <momentree/sweep/plan/read_sweep.hpp>
#include <momentree/sweep/scenario_worlds.hpp>
#include <momentree/sweep/world_run.hpp>

namespace momentree::cli {

namespace {

using namespace std::chrono_literals;
using sweep::Coordinator;

// "1200 of 100000 worlds · 3 failed · 152 per second · 10:42 left", on a terminal.
class SweepLine {
 public:
  SweepLine(std::uint64_t worlds, bool shown) : worlds_(worlds), shown_(shown) {}
  ~SweepLine() { clear(); }
  SweepLine(const SweepLine&) = delete;
  SweepLine& operator=(const SweepLine&) = delete;

  void at(const Coordinator::Progress& progress) {
    const auto now = std::chrono::steady_clock::now();
    if (!shown_ || now < next_) return;
    next_ = now + 200ms;
    std::string text =
        format("\r%llu of %llu worlds", static_cast<unsigned long long>(progress.done), static_cast<unsigned long long>(worlds_));
    if (progress.failed > 0) text += format(" · %llu failed", static_cast<unsigned long long>(progress.failed));
    if (progress.rate > 0) {
      const double left = std::min(static_cast<double>(worlds_ - progress.done) / progress.rate, 3.6e8);
      const long seconds = std::lround(left);
      text += format(" · %.4g per second", progress.rate);
      text += seconds < 3600 ? format(" · %ld:%02ld left", seconds / 60, seconds % 60)
                             : format(" · %ld:%02ld:%02ld left", seconds / 3600, seconds / 60 % 60, seconds % 60);
    }
    std::fputs((text + "\x1b[K").c_str(), stderr);
    std::fflush(stderr);
    drawn_ = true;
  }
  void clear() {
    if (drawn_) std::fputs("\r\x1b[K", stderr);
    drawn_ = false;
  }

 private:
  std::uint64_t worlds_;
  bool shown_, drawn_ = false;
  std::chrono::steady_clock::time_point next_{};
};

std::string summary_text(const sweep::Sweep& sweep, const sweep::SweepSummary& summary, double seconds, std::uint64_t computed) {
  const Style style = Style::of_output();
  const std::string title = sweep.title.empty() ? sweep.name : sweep.title;
  std::string text = style.heading(printable(title)) + ": " + count_text(static_cast<long>(sweep.worlds()), "world", "worlds");
  if (summary.failed() > 0) text += format(", %llu of them failed", static_cast<unsigned long long>(summary.failed()));
  if (computed > 0) text += "; " + std::to_string(computed) + " computed in " + duration_text(seconds);
  Table table;
  table.row({"", "mean or share", "deviation or interval", "least", "greatest"});
  for (std::vector<std::string>& row : summary.table()) {
    row.front() = printable(row.front());
    table.row(std::move(row));
  }
  return text + "\n\n" + table.text("  ");
}

int run_one_world(const sweep::Sweep& sweep, const SweepOptions& options) {
  if (*options.world >= sweep.worlds())
    throw_error({"there is no world " + std::to_string(*options.world) + ": the sweep has " + std::to_string(sweep.worlds()),
                 "--world", "the first is 0"});
  RunOptions run_options;
  run_options.scenario = sweep.scenario->path;
  run_options.overrides = sweep.overrides(*options.world);
  run_options.out = options.out.empty() ? "results/" + sweep.name + "-world-" + std::to_string(*options.world) : options.out;
  run_options.report = options.report, run_options.quiet = options.quiet, run_options.json = options.json;
  if (!options.quiet && !options.json) show(stderr, printable(run_command(sweep, *options.world)) + '\n');
  sweep::Observation observation(sweep.measures);
  run_options.run_to_end = [&](Simulation& simulation, double until) {
    return run_world(simulation, until, sweep.stop, observation);
  };
  return run(run_options);
}

int say_complete(const std::string& out, const SweepOptions& options) {
  if (options.json)
    std::fputs(complete_summary(out).c_str(), stdout);
  else if (!options.quiet)
    show(stdout, "The sweep is complete already. Results: " + printable(out) + '\n');
  return done;
}

void report_failure(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const Error& error) {
    show(stderr, (error.where.empty() ? "momentree: " : "") + error.message() + '\n');
  } catch (const std::bad_alloc&) {
    show(stderr, "momentree: error: out of memory\n");
  } catch (const std::exception& error) {
    show(stderr, "momentree: error: " + printable(error.what()) + '\n');
  }
}

// Nothing is given to other ranks.
class NoWork final : public sweep::WorkSource {
 public:
  std::optional<sweep::Chunk> next() override { return std::nullopt; }
  void finished(sweep::Chunk, std::string) override {}
  bool complete() const override { return true; }
  void give_again(sweep::Chunk) override {}
};

// What the first rank does alone, while the others wait for its end.
int conclude_alone(const sweep::Sweep& sweep, sweep::Communicator& ranks, sweep::Lanes lanes,
                   const std::function<int()>& action) {
  NoWork none;
  sweep::DistributeOptions how;
  how.version = sweep::program_text(lanes), how.work = sweep.hash;
  how.conclude = [&](sweep::Ending ending, const std::exception_ptr& failure) {
    try {
      if (failure) std::rethrow_exception(failure);
      return ending == sweep::Ending::interrupted ? static_cast<int>(interrupted) : action();
    } catch (...) {
      report_failure(std::current_exception());
      return static_cast<int>(failed);
    }
  };
  return distribute(
      &ranks, &none, [](sweep::Chunk) { return std::string(); }, how);
}

int threads_of(const SweepOptions& options, const sweep::Communicator* ranks) {
  if (options.jobs > 0) return options.jobs;
  return ranks != nullptr ? 1 : static_cast<int>(std::max(std::thread::hardware_concurrency(), 1u));
}

// Another rank: computes what the first one gives it.
int work_for_others(const sweep::Sweep& sweep, sweep::Communicator& ranks, const SweepOptions& options) {
  const InterruptGuard guard;
  std::atomic<bool> cancel = false, stop = false;
  const sweep::Lanes lanes = lanes_for(sweep, sweep::lanes_of(options.lanes));
  const sweep::ScenarioWorlds worlds(sweep, lanes, &cancel);
  sweep::DistributeOptions how;
  how.threads = threads_of(options, &ranks);
  how.version = sweep::program_text(lanes), how.work = sweep.hash;
  how.stop = &stop, how.cancel = &cancel;
  how.progress = [&] {
    if (InterruptGuard::interrupted()) stop = true;
  };
  return distribute(
      &ranks, nullptr, [&worlds](sweep::Chunk chunk) { return worlds.run(chunk); }, how);
}

int run_sweep(const sweep::Sweep& sweep, sweep::Communicator* ranks, const SweepOptions& options) {
  const InterruptGuard guard;  // before there is a folder that would be left behind
  const sweep::Lanes lanes = lanes_for(sweep, sweep::lanes_of(options.lanes));
  SweepOutput output(sweep, lanes, options);
  if (output.found() > 0 && !options.quiet)
    show(stderr, printable(output.working()) + ": continues after " +
                     count_text(static_cast<long>(output.found()), "world", "worlds") + '\n');
  if (const sweep::Journal::Damage& damage = output.journal().damage(); damage.records > 0)
    show(stderr,
         printable(output.working()) + "/sweep.journal: warning: " +
             count_text(static_cast<long>(damage.records), "damaged record is", "damaged records are") + " skipped; " +
             (damage.worlds > 0 ? count_text(static_cast<long>(damage.worlds), "world is", "worlds are") : "their worlds are") +
             " computed again\n");
  std::atomic<bool> cancel = false, stop = false;
  const sweep::ScenarioWorlds worlds(sweep, lanes, &cancel);
  const int threads = threads_of(options, ranks);
  Coordinator work(output.journal(), {.workers = threads * (ranks != nullptr ? ranks->size() : 1), .multiple = worlds.at_once()});
  SweepLine line(sweep.worlds(), !options.quiet && errors_on_terminal());
  const auto start = std::chrono::steady_clock::now();
  const auto keep = [&] {
    show(stderr, "the results so far are kept in " + printable(output.working()) + "; the same command continues from them\n");
  };
  sweep::DistributeOptions how;
  how.threads = threads;
  how.version = sweep::program_text(lanes), how.work = sweep.hash;
  how.stop = &stop, how.cancel = &cancel;
  how.progress = [&] {
    if (InterruptGuard::interrupted()) stop = cancel = true;
    line.at(work.progress());
  };
  how.warn = [](const std::string& what) { show(stderr, "momentree: warning: " + printable(what) + '\n'); };
  how.conclude = [&](sweep::Ending ending, const std::exception_ptr& failure) {
    line.clear();
    try {
      if (ending == sweep::Ending::interrupted) {
        output.journal().flush();
        show(stderr, printable(sweep.path) + format(": interrupted after %llu of %llu worlds\n",
                                                    static_cast<unsigned long long>(work.progress().done),
                                                    static_cast<unsigned long long>(sweep.worlds())));
        keep();
        return static_cast<int>(interrupted);
      }
      if (ending == sweep::Ending::failed) {
        report_failure(failure);
        keep();
        return static_cast<int>(failed);
      }
      const std::optional<std::vector<std::string>> warnings = output.publish(options.report);
      if (!warnings) {
        show(stderr, printable(sweep.path) + ": interrupted while the report was written, after all worlds\n");
        keep();
        return static_cast<int>(interrupted);
      }
      for (const std::string& warning : *warnings) show(stderr, printable(warning) + '\n');
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      const sweep::SweepSummary& summary = output.summary();
      if (options.json)
        std::fputs(summary.json().c_str(), stdout);
      else if (!options.quiet)
        show(stdout, summary_text(sweep, summary, seconds, sweep.worlds() - output.found()) +
                         "\nResults: " + printable(output.destination()) + (options.report ? "/report.html\n" : "\n"));
      if (summary.failed() > 0)
        show(stderr, printable(sweep.path) + ": warning: " + count_text(static_cast<long>(summary.failed()), "world", "worlds") +
                         " failed; see the status of each, and failures.jsonl\n");
      return static_cast<int>(summary.done() > 0 ? done : failed);
    } catch (...) {
      report_failure(std::current_exception());
      keep();
      return static_cast<int>(failed);
    }
  };
  return distribute(
      ranks, &work, [&worlds](sweep::Chunk chunk) { return worlds.run(chunk); }, how);
}

}  // namespace

int sweep(const SweepOptions& options) {
  const std::unique_ptr<sweep::Communicator> ranks = sweep::launch();
  const bool first = !ranks || ranks->rank() == 0;
  const sweep::ReadSweep read = sweep::read_sweep(options.file);
  if (first) show(stderr, io::rendered(read.diagnostics));
  if (!read.sweep) return bad_input;
  const sweep::Sweep& all = *read.sweep;
  if (!first) return work_for_others(all, *ranks, options);
  const auto alone = [&](const std::function<int()>& action) {
    if (!ranks) return action();
    return conclude_alone(all, *ranks, lanes_for(all, sweep::lanes_of(options.lanes)), action);
  };
  if (options.world) return alone([&] { return run_one_world(all, options); });
  const std::string out = sweep_destination(all, options);
  if (options.resume && !options.restart && is_complete_sweep(all, out) && !needs_report(out, options))
    return alone([&] { return say_complete(out, options); });
  return run_sweep(all, ranks.get(), options);
}

}  // namespace momentree::cli
