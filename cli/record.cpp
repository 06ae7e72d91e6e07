#include <cli/record.hpp>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include <cli/exit_codes.hpp>
#include <cli/interrupt.hpp>
#include <cli/progress.hpp>
#include <cli/session.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/io/model_json.hpp>
#include <momentree/io/results.hpp>
#include <momentree/io/system_file.hpp>

namespace momentree::cli {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "momentree-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    throw_error({std::string("cannot make a temporary folder: ") + std::strerror(errno), name, ""});
  path_ = std::move(name);  // allocates no memory: a failure would leave the folder behind
}

TemporaryFolder::~TemporaryFolder() { io::remove_tree(path_); }

Recorded record(const io::Scenario& scenario, const std::string& folder, Purpose purpose) {
  Session session(scenario);
  show(stderr, io::rendered(session.schedule()));
  Simulation& simulation = session.simulation();
  const double start = simulation.time();
  const InterruptGuard guard;
  io::Recorder recorder(
      simulation, {scenario.name, scenario.title, scenario.path, scenario.hash, {}, start, scenario.until, scenario.integration},
      io::model_json(simulation.world(), scenario.title, scenario.shapes),
      {.directory = folder,
       .joints = session.joints(),
       .every = scenario.output_every,
       .reactions = purpose == Purpose::report,
       .energy = purpose == Purpose::report,
       .lasting = false});
  Progress progress(start, scenario.until, errors_on_terminal());
  simulation.observe(scenario.output_every, [&](const World& world) { return recorder.observe(world); });
  simulation.watch([&](double time) {
    progress.at(time);
    return !InterruptGuard::interrupted();
  });
  const Status status = simulation.run_until(scenario.until);
  progress.clear();
  std::string says = "done";
  if (status == Status::interrupted) says = "interrupted at t = " + std::to_string(simulation.time()) + " s";
  if (status != Status::ok && status != Status::interrupted) says = simulation.message();
  recorder.finish(says, session.armed());
  if (recorder.error()) throw_error(*recorder.error());
  if (status != Status::ok && status != Status::interrupted) show(stderr, printable(scenario.path) + ": error: " + says + '\n');
  return {recorder.directory(), status == Status::ok ? done : status == Status::interrupted ? interrupted : failed};
}

}  // namespace momentree::cli
