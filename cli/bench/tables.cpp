#include <cli/bench/tables.hpp>

#ifdef __linux__
#include <unistd.h>
#endif
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <bench/models.hpp>
#include <cli/bench/timing.hpp>
#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/dynamics/count.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/generate/kernel.hpp>
#include <momentree/generate/kernel_cache.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/topology/change.hpp>

namespace momentree::cli {

namespace {

std::string linear_text(long slope, long offset) {
  return format("%ld n ", slope) + (offset < 0 ? "− " : "+ ") + format("%ld", std::labs(offset));
}

/// Counted for two lengths, and checked for linearity at a third.
OperationsRow counted(const char* name, const Vec3& gravity, Model (*make)(int), const char* source) {
  const auto count = [&](int bodies) {
    Model model = make(bodies);
    model.set_gravity(gravity);
    return count_operations(compile(model));
  };
  const Operations a = count(10), b = count(20), c = count(100);
  const auto line = [&](long at_10, long at_20, long at_100) {
    const long slope = (at_20 - at_10) / 10;
    if (at_100 != at_10 + 90 * slope) throw Error{std::string(name) + ": operations are not linear in n", "", ""};
    return linear_text(slope, at_10 - 10 * slope);
  };
  return {name,
          line(a.additions, b.additions, c.additions),
          line(a.multiplications + a.divisions, b.multiplications + b.divisions, c.multiplications + c.divisions),
          line(a.total(), b.total(), c.total()),
          c.total(),
          source};
}

}  // namespace

EvaluationRow evaluation_time(const std::string& name, const Tree& tree, const State& start, double budget) {
  Workspace<double> work(tree);
  const std::vector<double> p(start.p().begin(), start.p().end());
  const std::vector<double> first(start.q().begin(), start.q().end()), q[2] = {first, moved(tree, first)};
  int which = 0;
  EvaluationRow row{name, tree.bodies(), tree.nv(), 0, 0};
  row.seconds = shortest(budget, [&] {
    which ^= 1;
    evaluate_stage(tree, 0, q[which].data(), p.data(), work);
    keep(work.pdot.get());
  });
  for (const int i : {0, 1}) {
    evaluate_stage(tree, 0, q[i].data(), p.data(), work);
    const double error = momentum_error(tree, q[i].data(), p.data(), work);
    if (!(error < 1e-9)) throw Error{name + ": the velocities found do not match the momenta", "", ""};
    row.error = std::max(row.error, error);
  }
  return row;
}

GeneratedRow generated_time(const std::string& name, const Tree& tree, const State& start, const KernelCache& kernels,
                            double budget) {
  Workspace<double> work(tree), other(tree);
  const std::vector<double> p(start.p().begin(), start.p().end());
  const std::vector<double> first(start.q().begin(), start.q().end()), q[2] = {first, moved(tree, first)};
  const RatesFunction rates = kernels.find(tree);
  if (rates == nullptr) throw Error{name + ": no code was generated: " + kernels.message(), "", ""};
  GeneratedRow row{name, tree.bodies(), {count_operations(tree).total(), kernel_expressions(tree).operations().total()}, {}, 0};
  int which = 0;
  const auto kernel = [&] {
    which ^= 1;
    evaluate_rates(tree, q[which].data(), p.data(), work);
    keep(work.pdot.get());
  };
  const auto generated = [&] {
    which ^= 1;
    rates(q[which].data(), p.data(), other.v.get(), other.qdot.get(), other.pdot.get());
    keep(other.pdot.get());
  };
  row.seconds[0] = row.seconds[1] = HUGE_VAL;
  const auto begin = Clock::now();
  do {  // alternately, so that disturbances by other load affect both
    row.seconds[0] = std::min(row.seconds[0], shortest(0, kernel));
    row.seconds[1] = std::min(row.seconds[1], shortest(0, generated));
  } while (since(begin) < budget);
  which = 0, kernel();
  which = 0, generated();
  double largest = 0, error = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double off = std::fabs(other.pdot[i] - work.pdot[i]);
    error = off <= error ? error : off;  // keeps NaN
    largest = std::max(largest, std::fabs(work.pdot[i]));
  }
  row.error = error / largest;
  if (!(row.error < 1e-9)) throw Error{name + ": the rates of the generated code differ from those of the kernels", "", ""};
  return row;
}

namespace {

EvaluationRow at_start(const std::string& name, const Model& model, double budget) {
  const Tree tree = compile(model);
  return evaluation_time(name, tree, start_state(model, tree), budget);
}

GeneratedRow at_start(const std::string& name, const Model& model, const KernelCache& kernels, double budget) {
  const Tree tree = compile(model);
  return generated_time(name, tree, start_state(model, tree), kernels, budget);
}

/// `ratio`: the expected ratio of kinetic energies; 0: any that is not a gain.
template <class Change>
ChangeRow change_time(const char* name, const char* model_name, const Model& model, bool floating, double ratio, double budget,
                      const Change& change) {
  Tree first = compile(model);
  State begin = start_state(model, first);
  Workspace<double> work(first);
  if (floating) {
    forward_dynamics(first, begin, work);
    apply(Break{first.inboard_joint({0})}, first, begin, work);
  }
  ChangeRow row{name, model_name, model.size(), 0, 0};
  row.seconds = shortest_change(budget, change, first, begin, work, row.energy);
  const bool right = ratio == 0 ? row.energy > 0 && row.energy <= 1 + 1e-9 : std::fabs(row.energy - ratio) < 1e-8;
  if (!right) throw Error{std::string(name) + ", " + model_name + ": the kinetic energy is wrong afterwards", "", ""};
  return row;
}

#ifdef __linux__
double resident_bytes() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr) return 0;
  long size = 0, resident = 0;
  const int read = std::fscanf(file, "%ld %ld", &size, &resident);
  std::fclose(file);
  return read == 2 ? static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) : 0;
}
#else
double resident_bytes() { return 0; }
#endif

}  // namespace

std::vector<OperationsRow> operations_table() {
  const char* const paper = "as printed in Naudet and Lefeber 2005, Table 1";
  const char* const lost = "not readable";
  return {{"Featherstone 1987", "275 n …", lost, "… − 238", 0, paper},
          {"Vukobratović et al. 1994", "231 n …", lost, "… − 566", 0, paper},
          {"Stejskal and Valášek 1996", "206 n − 345", "226 n − 343", "432 n − 688", 42512, paper},
          {"Rein 1993", "195 n …", lost, "… − 669", 0, paper},
          {"Naudet et al. 2003", "178 n …", lost, "363 n − 475", 35825, paper},
          counted("momentree", {}, bench::twisted_chain, "counted on the kernels")};
}

std::vector<OperationsRow> other_operations() {
  const Vec3 down{0, -9.81, 0};
  return {counted("general position, with gravity", down, bench::twisted_chain, "counted on the kernels"),
          counted("in a plane, without gravity", {}, bench::planar_chain, "counted on the kernels"),
          counted("in a plane, with gravity", down, bench::planar_chain, "counted on the kernels")};
}

BreakingChain breaking_chain(int repeats) {
  BreakingChain best;
  best.evaluation[0] = best.evaluation[1] = best.change = best.whole = HUGE_VAL;
  const auto start = Clock::now();
  for (int repeat = 0; repeat < repeats && (repeat == 0 || since(start) < 3); ++repeat) {
    Simulation simulation(bench::breaking_chain());
    simulation.at(1.8).then(break_joint("b/41"));
    if (simulation.run_until(3) != Status::ok) throw Error{simulation.result().reason, "", ""};
    const RunStatistics& s = simulation.statistics();
    for (const int i : {0, 1}) {
      best.evaluations[i] = s.evaluations[i];
      best.evaluation[i] = std::min(best.evaluation[i], s.evaluation_seconds[i] / static_cast<double>(s.evaluations[i]));
    }
    best.change = std::min(best.change, s.topology_seconds);
    best.whole = std::min(best.whole, s.total_seconds[0] + s.total_seconds[1]);
    if (s.changes != 1 || simulation.world().mechanisms().size() != 2)
      throw Error{"the breaking chain did not break as it should", "", ""};
  }
  return best;
}

void evaluation_times(double budget, const std::function<bool(const EvaluationRow&)>& row) {
  for (const int n : {7, 10, 100, 1000})
    if (!row(at_start("planar chain", bench::planar_chain(n), budget))) return;
  for (const int n : {7, 10, 100, 1000})
    if (!row(at_start("spatial chain", bench::spatial_chain(n), budget))) return;
  if (!row(at_start("binary tree", bench::binary_tree(63), budget))) return;
  row(at_start("humanoid", bench::humanoid(), budget));
}

std::string generated_times(double budget, const std::function<bool(const GeneratedRow&)>& row) {
  const KernelCache kernels({.most_operations = 20000});
  if (kernels.find(compile(bench::planar_chain(2))) == nullptr) return kernels.message();
  const auto time = [&](const char* name, const Model& model) { return row(at_start(name, model, kernels, budget)); };
  if (!time("arm", bench::arm())) return "";
  for (const int n : {2, 5, 10, 20})
    if (!time("planar chain", bench::planar_chain(n))) return "";
  for (const int n : {3, 7, 10})
    if (!time("spatial chain", bench::spatial_chain(n))) return "";
  time("humanoid", bench::humanoid());
  return "";
}

void change_times(double budget, const std::function<bool(const ChangeRow&)>& row) {
  for (const int n : {10, 100, 1000}) {
    const Model planar = bench::planar_chain(n), spatial = bench::spatial_chain(n);
    const JointId middle{n * 2 / 5};
    if (!row(change_time("break a joint", "planar chain", planar, false, 1, budget, Break{middle}))) return;
    if (!row(change_time("break a joint", "spatial chain", spatial, false, 1, budget, Break{middle}))) return;
    if (!row(change_time("lock a joint", "spatial chain", spatial, false, 0, budget, Lock{middle}))) return;
    if (!row(change_time("re-root", "spatial chain", spatial, true, 1, budget, Reroot{BodyId{n - 1}}))) return;
  }
}

namespace {

LargeRow large_world(const char* name, const Model& model) {
  LargeRow row{name, model.size(), HUGE_VAL, {}, 0};
  const double before = resident_bytes();
  const Tree tree = compile(model);
  const State state = start_state(model, tree);
  Workspace<double> work(tree);
  const double *q = state.q().data(), *p = state.p().data();
  const auto grown = [&] { return before == 0 ? 0 : (resident_bytes() - before) / model.size(); };
  for (int repeat = 0; repeat < 5; ++repeat) {
    const auto begin = Clock::now();
    evaluate_stage(tree, 0, q, p, work);
    keep(work.pdot.get());
    row.seconds = std::min(row.seconds, since(begin));
  }
  row.bytes[0] = grown();
  row.error = momentum_error(tree, q, p, work);
  if (!(row.error < 1e-6)) throw Error{std::string(name) + ": the velocities found do not match the momenta", "", ""};
  forward_dynamics(tree, state, work);
  row.bytes[1] = grown();
  return row;
}

}  // namespace

void large_worlds(int bodies, const std::function<bool(const LargeRow&)>& row) {
  static_cast<void>(large_world("steps that the process keeps", bench::rope(10)));
  static_cast<void>(large_world("steps that the process keeps", bench::spatial_chain(10)));
  if (row(large_world("rope", bench::rope(bodies)))) row(large_world("all bodies differ", bench::spatial_chain(bodies)));
}

}  // namespace momentree::cli
