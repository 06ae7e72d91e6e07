#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>

#include <cli/commands.hpp>
#include <cli/interrupt.hpp>
#include <cli/page.hpp>
#include <cli/progress.hpp>
#include <cli/run_report.hpp>
#include <cli/session.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/generate/kernel_cache.hpp>
#include <momentree/io/model_json.hpp>
#include <momentree/io/report/page.hpp>
#include <momentree/io/report/report.hpp>
#include <momentree/io/results.hpp>

namespace momentree::cli {

namespace {

void refuse_unsupported(const RunOptions& options) {
  const auto refuse = [](bool given, const char* option) {
    if (given) fail({"`" + std::string(option) + "` is not supported yet", "", ""});
  };
  refuse(!options.checkpoint.empty(), "--checkpoint");
  refuse(options.resume, "--resume");
  refuse(options.format == "hdf5", "--format hdf5");
  if (options.format != "csv") fail({"unknown format '" + options.format + "'", "", "there are csv and, later, hdf5"});
}

std::string status_text(Status status, const Simulation& simulation) {
  if (status == Status::ok) return "done";
  if (status == Status::interrupted) return format("interrupted at t = %.9g s", simulation.time());
  return simulation.message();
}

// What became of --generate.
void tell_about(const KernelCache& kernels, const io::Scenario& scenario, bool quiet) {
  const KernelCacheStatistics s = kernels.statistics();
  std::string why = kernels.message();
  if (scenario.integration.method == "damped")
    why = "the method damped has masses of its own, which generated code does not know";
  if (!why.empty()) show(stderr, printable(scenario.path) + ": warning: --generate: " + why + '\n');
  if (quiet || s.compiled == 0) return;
  std::printf("Generated code: %s compiled, found again %s, in %s\n", count_text(s.compiled, "topology", "topologies").c_str(),
              count_text(s.found_again, "time", "times").c_str(), duration_text(s.seconds).c_str());
}

}  // namespace

int run(const RunOptions& options) {
  refuse_unsupported(options);
  std::vector<std::string> overrides = options.overrides;
  if (!options.until.empty()) overrides.push_back("integrate.until=" + options.until);
  const std::optional<io::Scenario> scenario =
      load(options.scenario, overrides, options.quiet ? io::Severity::warning : io::Severity::note);
  if (!scenario) return bad_input;

  Session session(*scenario);
  session.schedule();
  Simulation& simulation = session.simulation();
  const double start = simulation.time();
  const int freedoms = simulation.world().tree().nv();
  io::Recorder recorder(scenario->model, session.joints(), scenario->output_every,
                        options.out.empty() ? "results/" + scenario->name : options.out, options.reactions);
  recorder.record_energy(simulation);

  Progress progress(start, scenario->until, !options.quiet && errors_on_terminal());
  const InterruptGuard guard;
  double largest_kinetic = 0;
  simulation.observe(scenario->output_every, [&](const World& world) {
    largest_kinetic = std::max(largest_kinetic, world.totals().kinetic);
    return recorder.observe(world);
  });
  simulation.watch([&progress](double time) {
    progress.at(time);
    return !InterruptGuard::interrupted();
  });
  std::optional<KernelCache> kernels;
  if (options.generate) simulation.use_generated(kernels.emplace().provider());
  const Status ended = simulation.run_until(scenario->until);
  progress.clear();

  const io::RunOrigin origin{scenario->name, scenario->title, scenario->path,  scenario->hash,
                             overrides,      start,           scenario->until, scenario->integration};
  const std::optional<Error> unwritten = recorder.error();
  std::string status = unwritten ? "failed: " + unwritten->message() : status_text(ended, simulation);
  std::optional<Error> trouble = unwritten;
  try {
    recorder.finish(origin, status, simulation, session.armed(),
                    io::model_json(scenario->model, scenario->title, scenario->shapes), [&](const std::filesystem::path& folder) {
                      if (!options.report) return;
                      io::write_text_file((folder / "report.html").string(),
                                          io::report_page(report_html(), io::report_data(folder)));
                    });
  } catch (const Error& error) {
    if (!trouble) trouble = error;
    if (!unwritten) status = "failed: " + error.message();
  }

  if (options.json)
    std::fputs(io::summary_json(origin, status, simulation).c_str(), stdout);
  else if (!options.quiet)
    show(stdout, report_text({scenario->title.empty() ? scenario->name : scenario->title, scenario->integration, start, freedoms,
                              largest_kinetic},
                             simulation, Style::of_output()) +
                     "\nResults: " + printable(recorder.directory()) + (options.report ? "/report.html\n" : "\n"));

  if (kernels) tell_about(*kernels, *scenario, options.quiet || options.json);
  if (trouble) show(stderr, trouble->message() + '\n');
  if (ended == Status::ok && !trouble) return done;
  if (!trouble) show(stderr, printable(scenario->path) + (ended == Status::interrupted ? ": " : ": error: ") + status + '\n');
  show(stderr, "what was computed is kept in " + printable(recorder.directory()) + '\n');
  return trouble || ended != Status::interrupted ? failed : interrupted;
}

}  // namespace momentree::cli
