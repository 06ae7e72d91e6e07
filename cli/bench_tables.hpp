#pragma once
// What `momentree bench` finds: operations that are counted, times that are measured on this machine.
#include <functional>
#include <string>
#include <vector>

#include <momentree/generate/kernel_cache.hpp>
#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree::cli {

/// Operations as printed: "316 n − 354", or what of it can be read.
struct OperationsRow {
  std::string algorithm, additions, multiplications, total;
  long of_100 = 0;  ///< total for 100 bodies; 0: not known
  std::string source;
};
/// Rows of the paper's Table 1 as published, and ours, counted on the kernels: n pins in general position, without gravity.
std::vector<OperationsRow> operations_table();
/// The same kernels on other chains: what gravity adds, and what structure saves.
std::vector<OperationsRow> other_operations();

/// The breaking chain, 3 s of RK4 at 1 ms: [0] before and [1] after body 41 falls off, as in the paper's Table 2.
struct BreakingChain {
  long evaluations[2]{};
  double evaluation[2]{};  ///< s per evaluation
  double change = 0;       ///< s
  double whole = 0;        ///< s, the run
};
/// The shortest of `repeats` runs, of fewer where three seconds have passed.
BreakingChain breaking_chain(int repeats);

/// Time of one evaluation of q̇ and ṗ with joint forces; every coordinate differs from that of the evaluation before.
struct EvaluationRow {
  std::string model;
  int bodies = 0, dofs = 0;
  double seconds = 0;
  double error = 0;  ///< of the momenta that the velocities found belong to, as a share of the largest
};
/// Calls `row` with each as it is measured, `budget` seconds for each; stops where that returns false.
void evaluation_times(double budget, const std::function<bool(const EvaluationRow&)>& row);
/// Of one tree, from that state on, in which something moves. Throws Error where the velocities found are wrong.
EvaluationRow evaluation_time(const std::string& name, const Tree& tree, const State& start, double budget);

/// Time of a change alone, without the evaluations before and after it.
struct ChangeRow {
  std::string change, model;
  int bodies = 0;
  double seconds = 0;
  double energy = 0;  ///< kinetic energy after it, as a share of what it was
};
void change_times(double budget, const std::function<bool(const ChangeRow&)>& row);

/// An evaluation of the rates alone, by the kernels and by code generated for the topology; one after the other, in turn.
struct GeneratedRow {
  std::string model;
  int bodies = 0;
  long operations[2]{};  ///< of the kernels; of the generated code
  double seconds[2]{};
  double error = 0;  ///< of the generated code's rates of momenta, as a share of the largest
};
/// As above; returns why there is no such row, empty if there are.
std::string generated_times(double budget, const std::function<bool(const GeneratedRow&)>& row);
/// Of one tree likewise. Throws Error where there is no code for it, or it finds other rates than the kernels.
GeneratedRow generated_time(const std::string& name, const Tree& tree, const State& start, const KernelCache& kernels,
                            double budget);

/// A chain so long that it is its memory that takes the time.
struct LargeRow {
  std::string model;
  int bodies = 0;
  double seconds = 0;  ///< of an evaluation
  double bytes[2]{};   ///< per body: after evaluations as a step has them, and after one for changes and results; 0: not told
  double error = 0;    ///< as above
};
/// Resident memory of the process that Tree, State and Work make more, the model and its names apart: what evaluations have not
/// touched is not in it. Call it before anything that frees much memory.
void large_worlds(int bodies, const std::function<bool(const LargeRow&)>& row);

}  // namespace momentree::cli
