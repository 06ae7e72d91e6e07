#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>

#include <cli/commands.hpp>
#include <cli/interrupt.hpp>
#include <cli/progress.hpp>
#include <cli/session.hpp>
#include <momentree/io/model_json.hpp>
#include <momentree/io/results.hpp>
#include <momentree/io/svg.hpp>

namespace momentree::cli {

namespace {

namespace fs = std::filesystem;

/// Holds the results of a scenario that is run for its picture alone.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "momentree-view-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) fail({std::string("cannot make a temporary folder: ") + std::strerror(errno), name, ""});
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string result() const { return (path_ / "result").string(); }

 private:
  fs::path path_;
};

/// Runs a scenario into a folder; exit code.
int record(const io::Scenario& scenario, const std::string& folder) {
  Session session(scenario);
  session.schedule();
  Simulation& simulation = session.simulation();
  io::Recorder recorder(scenario.model, session.joints(), scenario.output_every, folder);
  Progress progress(simulation.time(), scenario.until, errors_on_terminal());
  const InterruptGuard guard;
  simulation.observe(scenario.output_every, [&](const World& world) { return recorder.observe(world); });
  simulation.watch([&](double time) {
    progress.at(time);
    return !InterruptGuard::interrupted();
  });
  const Status status = simulation.run_until(scenario.until);
  progress.clear();
  if (recorder.error()) fail(*recorder.error());
  if (status == Status::interrupted) return interrupted;
  if (status != Status::ok) {
    std::fprintf(stderr, "%s: error: %s\n", scenario.path.c_str(), simulation.message().c_str());
    return failed;
  }
  recorder.finish({scenario.name, scenario.title, scenario.path, scenario.hash, {}, 0, scenario.until, scenario.integration},
                  "done", simulation, session.armed(), io::model_json(scenario.model, scenario.title, scenario.shapes));
  return done;
}

}  // namespace

int view(const ViewOptions& options) {
  if (options.svg.empty()) fail({"the interactive viewer is not supported yet", "", "draw the run with --svg FILE"});
  io::PictureOptions picture;
  picture.every = options.every;
  if (!options.look.empty()) picture.look = io::parse_direction(options.look);
  if (options.layout == "multiples")
    picture.layout = io::PictureOptions::Layout::multiples;
  else if (options.layout != "overlay")
    fail({"there is no layout '" + options.layout + "'", "--layout", "one of: overlay, multiples"});
  if (fs::is_directory(options.source)) {
    io::write_svg(options.source, options.svg, picture);
  } else {
    const std::optional<io::Scenario> scenario = load(options.source, {});
    if (!scenario) return bad_input;
    const TemporaryFolder folder;
    if (const int code = record(*scenario, folder.result()); code != done) return code;
    io::write_svg(folder.result(), options.svg, picture);
  }
  std::printf("%s\n", options.svg.c_str());
  return done;
}

}  // namespace momentree::cli
