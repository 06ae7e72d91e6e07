#include <cli/record.hpp>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include <cli/exit_codes.hpp>
#include <cli/input.hpp>
#include <cli/interrupt.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/models/mesh/pack.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/text/files/system_file.hpp>

namespace momentree::cli {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "momentree-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    throw_error({std::string("cannot make a temporary folder: ") + std::strerror(errno), name, ""});
  path_ = std::move(name);  // allocates no memory: a failure would leave the folder behind
}

TemporaryFolder::~TemporaryFolder() { io::remove_tree(path_); }

void watch_run(Simulation& simulation, io::Recorder& recorder, double every, Progress& progress, double checkpoints) {
  using Clock = std::chrono::steady_clock;
  simulation.observe(every, [&recorder](const World& world) { return recorder.observe(world); });
  simulation.watch([&recorder, &progress, checkpoints, saved = Clock::now()](double time) mutable {
    progress.at(time);
    const bool ends = InterruptGuard::interrupted();
    if (checkpoints == 0) return !ends;
    if (!ends && std::chrono::duration<double>(Clock::now() - saved).count() < checkpoints) return true;
    const bool fine = recorder.save(checkpoints);
    saved = Clock::now();
    return fine && !ends;
  });
}

std::string status_text(const RunResult& ended, const Simulation& simulation) {
  if (ended) return "done";
  if (ended == Status::interrupted) return format("interrupted at t = %.9g s", simulation.time());
  return ended.reason;
}

Recorded record(const io::Scenario& scenario, const std::string& folder, Purpose purpose,
                const std::function<RunResult(Simulation&, double)>& run_to_end) {
  io::Session session(scenario);
  show(stderr, io::rendered(session.schedule()));
  Simulation& simulation = session.simulation();
  const double start = simulation.time();
  const InterruptGuard guard;
  const io::PackedMeshes meshes = io::meshes_json(io::mesh_sources(scenario.shapes));
  show(stderr, io::rendered(meshes.warnings));
  io::Recorder recorder(
      simulation, {scenario.name, scenario.title, scenario.path, scenario.hash, {}, start, scenario.until, scenario.integration},
      io::model_json(simulation.world(), scenario.title, scenario.shapes),
      {.directory = folder,
       .joints = session.joints(),
       .every = scenario.output_every,
       .reactions = purpose == Purpose::report,
       .energy = purpose == Purpose::report,
       .lasting = false,
       .meshes = meshes.json});
  Progress progress(start, scenario.until, errors_on_terminal());
  watch_run(simulation, recorder, scenario.output_every, progress);
  const RunResult ended = run_to_end ? run_to_end(simulation, scenario.until) : simulation.run_until(scenario.until);
  progress.clear();
  const std::string says = status_text(ended, simulation);
  recorder.finish(says, session.armed());
  if (recorder.error()) throw_error(*recorder.error());
  if (!ended && ended != Status::interrupted) show(stderr, printable(scenario.path) + ": error: " + says + '\n');
  return {recorder.directory(), ended ? done : ended == Status::interrupted ? interrupted : failed};
}

}  // namespace momentree::cli
