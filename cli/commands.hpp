#pragma once
// The commands, one function each; command_line.cpp turns the command line into their options. All return an exit code, print
// messages to standard error and results to standard output, and throw Error for bad input.
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <cli/exit_codes.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::cli {

struct RunOptions {
  std::string scenario;
  std::string out;                     ///< empty: results/<scenario's name>
  std::vector<std::string> overrides;  ///< KEY=VALUE
  std::string until;
  std::string format = "csv";  ///< or "hdf5"
  double checkpoint = 0;       ///< wall-clock time between checkpoints (s); 0: none, or for a resumed run as before
  bool resume = false;
  /// How the simulation is run to its end (s); empty: run_until.
  std::function<RunResult(Simulation& simulation, double until)> run_to_end{};
  bool report = false, reactions = false, quiet = false, json = false, generate = false, verbose = false;
};
int run(const RunOptions& options);

struct SweepOptions {
  std::string file;
  std::string out;                     ///< empty: as the sweep says, or results/<sweep's name>
  std::string lanes = "auto";          ///< see sweep::lanes_of()
  int jobs = 0;                        ///< threads; 0: as many as the machine has, or 1 per rank under MPI
  std::optional<std::uint64_t> world;  ///< run this world alone, with all results
  bool resume = false, restart = false, accept_changes = false;
  bool report = false, quiet = false, json = false;
};
int sweep(const SweepOptions& options);

struct CompareOptions {
  std::string one, other;  ///< result folders
  double tolerance = 0;
  bool json = false;
};
/// Returns `done` if the results are equal, `failed` if they differ.
int compare(const CompareOptions& options);

struct CheckOptions {
  std::vector<std::string> files;
  bool json = false, verbose = false;
};
int check(const CheckOptions& options);

struct EvaluateOptions {
  std::string scenario, state;
  std::vector<std::string> overrides;
  bool equilibrium = false;
  bool json = false, verbose = false;
};
int evaluate(const EvaluateOptions& options);

struct ExplainOptions {
  std::string scenario;
  std::vector<std::string> overrides;
  bool code = false;
  bool verbose = false;
};
int explain(const ExplainOptions& options);

struct ConvertOptions {
  std::string source, out;  ///< "-": TOML to standard output
  std::string mechanism;    ///< for a URDF; empty: the only one
  std::vector<std::string> overrides;
  bool verbose = false;
};
int convert(const ConvertOptions& options);

struct CompileOptions {
  std::string scenario, out;  ///< "-": standard output
  std::string name;           ///< prefix of the generated names; empty: the scenario's name
  std::vector<std::string> overrides;
  Variables variables = Variables::momenta;
  bool without_joint_forces = false, verbose = false;
};
int compile(const CompileOptions& options);

struct ViewOptions {
  std::string source, svg;
  std::string exported{};  ///< a file for other programs; empty: none
  double every = 0;
  std::string look;
  std::string layout = "overlay";      ///< or "multiples"
  int port = 0;                        ///< 0: any free port
  std::vector<std::string> overrides;  ///< of a live run
  bool live = false, no_browser = false, verbose = false;
};
int view(const ViewOptions& options);

struct PlayOptions {
  std::string source;  ///< empty: the playground's own gallery
  std::vector<std::string> overrides;
  int port = 0;  ///< 0: any free port
  bool no_browser = false, verbose = false;
};
int play(const PlayOptions& options);

struct BenchOptions {
  std::vector<std::string> models{};  ///< scenarios or models to measure instead of the tables
  bool json = false;
  double budget = 0.15;           ///< s for each figure
  int repeats = 5;                ///< of the breaking chain
  std::string peers{};            ///< folder of the programs peer-*; empty: none
  int bodies = 1000000;           ///< of the largest chains
  char** command_line = nullptr;  ///< the arguments of main, for the program that does the measurements
};
/// Returns `failed` if a result is wrong: its time is not printed. Each program has its own definition: momentree starts
/// momentree-measure (bench.cpp), which measures (bench/bench.cpp).
int bench(const BenchOptions& options);
using Bench = int (*)(const BenchOptions& options);

}  // namespace momentree::cli
