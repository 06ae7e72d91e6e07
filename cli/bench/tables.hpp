#pragma once
// The results of `momentree bench`: counted operations, and times measured on this machine.
#include <functional>
#include <string>
#include <vector>

#include <momentree/generate/kernel_cache.hpp>
#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree::cli {

/// Operations as printed: "315 n − 434", or the readable part of it.
struct OperationsRow {
  std::string algorithm, additions, multiplications, total;
  long of_100 = 0;  ///< total for 100 bodies; 0: unknown
  std::string source;
};
/// Rows of the paper's Table 1 as published, and momentree's, counted on the kernels: n revolute joints in general position,
/// without gravity.
std::vector<OperationsRow> operations_table();
/// The same kernels on other chains: the cost of gravity, and the savings from structure.
std::vector<OperationsRow> other_operations();

/// The breaking chain, 3 s of RK4 at 1 ms: [0] before and [1] after body 41 falls off, as in the paper's Table 2.
struct BreakingChain {
  long evaluations[2]{};
  double evaluation[2]{};  ///< s per evaluation
  double change = 0;       ///< s
  double whole = 0;        ///< s, the run
};
/// The shortest of `repeats` runs, or of fewer once three seconds have passed.
BreakingChain breaking_chain(int repeats);

/// Time of one evaluation of q̇ and ṗ with joint forces; every coordinate differs from the previous evaluation.
struct EvaluationRow {
  std::string model;
  int bodies = 0, dofs = 0;
  double seconds = 0;
  double error = 0;  ///< of the momenta recomputed from the velocities found, relative to the largest momentum
};
/// Calls `row` with each result as it is measured, spending `budget` seconds on each; stops if that returns false.
void evaluation_times(double budget, const std::function<bool(const EvaluationRow&)>& row);
/// For one tree, starting from that state, in which something moves. Throws Error if the velocities found are wrong.
EvaluationRow evaluation_time(const std::string& name, const Tree& tree, const State& start, double budget);

/// Time of a topology change alone, without the evaluations before and after it.
struct ChangeRow {
  std::string change, model;
  int bodies = 0;
  double seconds = 0;
  double energy = 0;  ///< kinetic energy after the change, relative to that before it
};
void change_times(double budget, const std::function<bool(const ChangeRow&)>& row);

/// An evaluation of the rates alone, by the kernels and by code generated for the topology, measured alternately.
struct GeneratedRow {
  std::string model;
  int bodies = 0;
  long operations[2]{};  ///< of the kernels; of the generated code
  double seconds[2]{};
  double error = 0;  ///< of the generated code's momentum rates, relative to the largest
};
/// As above; returns why there are no rows, or an empty string if there are.
std::string generated_times(double budget, const std::function<bool(const GeneratedRow&)>& row);
/// Likewise for one tree. Throws Error if no code can be generated for it, or if its rates differ from those of the kernels.
GeneratedRow generated_time(const std::string& name, const Tree& tree, const State& start, const KernelCache& kernels,
                            double budget);

/// A chain so long that the evaluation time is dominated by memory access.
struct LargeRow {
  std::string model;
  int bodies = 0;
  double seconds = 0;  ///< of an evaluation
  double bytes[2]{};   ///< per body: after evaluations as in a step, and after one for changes and results; 0: unknown
  double error = 0;    ///< as above
};
/// Resident memory that Tree, State and Work add to the process, without the model and its names; memory not touched by
/// evaluations is not included. Call it before anything that frees much memory.
void large_worlds(int bodies, const std::function<bool(const LargeRow&)>& row);

}  // namespace momentree::cli
