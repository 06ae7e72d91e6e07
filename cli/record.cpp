#include <cli/record.hpp>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <cli/exit_codes.hpp>
#include <cli/interrupt.hpp>
#include <cli/progress.hpp>
#include <cli/session.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/io/model_json.hpp>
#include <momentree/io/results.hpp>

namespace momentree::cli {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "momentree-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) fail({std::string("cannot make a temporary folder: ") + std::strerror(errno), name, ""});
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

Recorded record(const io::Scenario& scenario, const std::string& folder, double until, Purpose purpose) {
  Session session(scenario);
  session.schedule();
  Simulation& simulation = session.simulation();
  const double start = simulation.time();
  io::Recorder recorder(scenario.model, session.joints(), scenario.output_every, folder, purpose == Purpose::report);
  if (purpose == Purpose::report) recorder.record_energy(simulation);
  Progress progress(start, until, errors_on_terminal());
  const InterruptGuard guard;
  simulation.observe(scenario.output_every, [&](const World& world) { return recorder.observe(world); });
  simulation.watch([&](double time) {
    progress.at(time);
    return !InterruptGuard::interrupted();
  });
  const Status status = simulation.run_until(until);
  progress.clear();
  if (recorder.error()) fail(*recorder.error());
  std::string says = "done";
  if (status == Status::interrupted) says = "interrupted at t = " + std::to_string(simulation.time()) + " s";
  if (status != Status::ok && status != Status::interrupted) {
    says = simulation.message();
    show(stderr, printable(scenario.path) + ": error: " + says + '\n');
  }
  recorder.finish({scenario.name, scenario.title, scenario.path, scenario.hash, {}, start, scenario.until, scenario.integration},
                  says, simulation, session.armed(), io::model_json(scenario.model, scenario.title, scenario.shapes));
  return {recorder.directory(), status == Status::ok ? done : status == Status::interrupted ? interrupted : failed};
}

}  // namespace momentree::cli
