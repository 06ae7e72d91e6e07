#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>

#include <cli/commands.hpp>
#include <cli/input.hpp>
#include <cli/interrupt.hpp>
#include <cli/page.hpp>
#include <cli/record.hpp>
#include <cli/run_report.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/generate/kernel_cache.hpp>
#include <momentree/models/mesh/pack.hpp>
#include <momentree/results/checkpoint/checkpoint.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/text/files/table_file.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::cli {

namespace {

// Reports the result of --generate.
void report_generated_code(const KernelCache& kernels, const io::Scenario& scenario, bool quiet) {
  const KernelCacheStatistics s = kernels.statistics();
  std::string why = kernels.message();
  if (scenario.integration.method == "damped")
    why = "the method damped modifies the masses, which generated code does not support";
  if (!why.empty()) show(stderr, printable(scenario.path) + ": warning: --generate: " + why + '\n');
  if (quiet || s.compiled == 0) return;
  std::printf("Generated code: %s compiled, found again %s, in %s\n", count_text(s.compiled, "topology", "topologies").c_str(),
              count_text(s.found_again, "time", "times").c_str(), duration_text(s.seconds).c_str());
}

void report_location(const io::Recorder& recorder) {
  show(stderr, "the results so far are kept in " + printable(recorder.directory()) + '\n');
}

int say_complete(const std::string& out, const RunOptions& options) {
  if (options.json)
    std::fputs(io::read_text_file((std::filesystem::path(out) / "summary.json").string()).c_str(), stdout);
  else if (!options.quiet)
    show(stdout, "The run is complete already. Results: " + printable(out) + '\n');
  return done;
}

}  // namespace

int run(const RunOptions& options) {
  if (options.format == "hdf5") io::require_hdf5();
  std::vector<std::string> overrides = options.overrides;
  if (!options.until.empty()) overrides.push_back("integrate.until=" + options.until);
  const std::shared_ptr<const io::Scenario> scenario =
      load(options.scenario, overrides, notes_of(options.verbose), options.quiet ? io::Severity::warning : io::Severity::note);
  if (!scenario) return bad_input;

  const std::string out = options.out.empty() ? "results/" + scenario->name : options.out;
  const bool saves = options.checkpoint > 0 || options.resume;
  if (saves && options.generate)
    throw_error({"--generate cannot be combined with --checkpoint and --resume: generated code is not part of a checkpoint", "",
                 "leave out --generate"});
  std::optional<io::RunInput> input;
  if (saves) input = io::run_input(*scenario, options.reactions);
  std::optional<io::Interrupted> former;
  if (options.resume) former = io::find_checkpoint(out, *input);
  if (options.resume && !former && io::is_complete(out, *input)) {
    if (options.report && !std::filesystem::exists(std::filesystem::path(out) / "report.html"))
      throw_error({"these results are complete, but have no report", out,
                   "`momentree view` shows them; without --resume the run starts again, with a report"});
    return say_complete(out, options);
  }

  io::Session session(scenario);
  show(stderr, io::rendered(session.schedule()));
  Simulation& simulation = session.simulation();
  const double start = simulation.time();
  const int dofs = simulation.world().tree().nv();
  const InterruptGuard guard;  // before there is a folder that would be left behind
  io::RunOrigin origin = io::run_origin(*scenario, simulation, scenario->until);
  origin.overrides = overrides, origin.reactions = options.reactions;
  io::RecordOptions record{.directory = out,
                           .joints = session.joints(),
                           .every = scenario->output_every,
                           .reactions = options.reactions,
                           .report = options.report,
                           .hdf5 = options.format == "hdf5",
                           .input = input};
  std::unique_ptr<io::Recorder> begun;
  const double every = former && options.checkpoint == 0 ? former->checkpoint.every : options.checkpoint;
  if (former) {
    begun = std::make_unique<io::Recorder>(simulation, origin, record, *former);
  } else {
    io::PackedMeshes meshes = io::meshes_json(io::mesh_sources(scenario->shapes));
    if (!options.quiet) show(stderr, io::rendered(meshes.warnings));
    record.meshes = std::move(meshes.json);
    begun = std::make_unique<io::Recorder>(simulation, origin,
                                           io::model_json(simulation.world(), scenario->title, scenario->shapes), record);
  }
  io::Recorder& recorder = *begun;

  Progress progress(start, scenario->until, !options.quiet && errors_on_terminal());
  watch_run(simulation, recorder, scenario->output_every, progress, every);
  if (former) {
    io::continue_run(simulation, former->checkpoint);
    if (!options.quiet) show(stderr, printable(scenario->path) + format(": resumes at t = %.9g s\n", simulation.time()));
  }
  std::optional<KernelCache> kernels;
  if (options.generate) simulation.use_generated(kernels.emplace().provider());
  RunResult ended{Status::refused};
  try {
    ended = options.run_to_end ? options.run_to_end(simulation, scenario->until) : simulation.run_until(scenario->until);
  } catch (const std::bad_alloc&) {  // during a step or an event
    progress.clear();
    recorder.abandon("failed: out of memory");
    show(stderr, printable(scenario->path) + ": error: out of memory\n");
    report_location(recorder);
    return failed;
  }
  progress.clear();

  io::ReportPage report;
  if (options.report) report = &report_of;
  recorder.finish(status_text(ended, simulation), session.armed(), report);

  if (options.json)
    std::fputs(recorder.summary().c_str(), stdout);
  else if (!options.quiet)
    show(stdout, report_text({scenario->title.empty() ? scenario->name : scenario->title, scenario->integration, start, dofs},
                             simulation, Style::of_output()) +
                     "\nResults: " + printable(recorder.directory()) + (recorder.has_report() ? "/report.html\n" : "\n"));

  for (const std::string& warning : io::run_warnings(origin, simulation))
    show(stderr, printable(scenario->path) + ": warning: " + printable(warning) + '\n');
  if (kernels) report_generated_code(*kernels, *scenario, options.quiet || options.json);
  for (const std::string& warning : recorder.warnings()) show(stderr, warning + '\n');
  if (recorder.is_published()) return done;
  const std::optional<Error>& error = recorder.error();
  if (error)
    show(stderr, (error->where.empty() ? "momentree: " : "") + error->message() + '\n');
  else
    show(stderr, printable(scenario->path) + (ended == Status::interrupted ? ": " : ": error: ") + recorder.status() + '\n');
  report_location(recorder);
  return error || ended != Status::interrupted ? failed : interrupted;
}

}  // namespace momentree::cli
