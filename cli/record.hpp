#pragma once
// What all commands that run a scenario share; runs for a picture only, with results in a temporary folder.
#include <functional>
#include <string>

#include <cli/progress.hpp>
#include <momentree/results/results.hpp>
#include <momentree/scenario/scenario.hpp>

namespace momentree::cli {

/// A folder that is removed by the destructor.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string result() const { return file("result"); }
  std::string file(const std::string& name) const { return path_ + '/' + name; }

 private:
  std::string path_;
};

struct Recorded {
  std::string folder;  ///< contains the results, complete or not
  int code = 0;        ///< exit code of the run; errors have been reported
};

/// The results needed: motion and meshes for a picture, or everything in the report, including joint reactions and energy.
enum class Purpose { picture, report };

/// Writes a row of the recorder every `every` seconds of the run and shows its progress; the run ends if the user interrupts it.
/// `checkpoints`: the wall-clock time between checkpoints (s), of which the last is written at an interrupt; 0: none.
void watch_run(Simulation& simulation, io::Recorder& recorder, double every, Progress& progress, double checkpoints = 0);
/// How a run ended, as in summary.json.
std::string status_text(const RunResult& ended, const Simulation& simulation);

/// Runs a scenario into a folder. `run_to_end`: how the simulation is run to its end (s); empty: run_until.
Recorded record(const io::Scenario& scenario, const std::string& folder, Purpose purpose,
                const std::function<RunResult(Simulation&, double)>& run_to_end = {});

}  // namespace momentree::cli
