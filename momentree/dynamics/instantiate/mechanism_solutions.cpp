// The solution for one mechanism: apart from solutions.cpp, so that the passes over all bodies are compiled for themselves.
#include <algorithm>

#include <momentree/dynamics/solve.ipp>

namespace momentree {

template <class T>
void solve_mechanism(const Tree& tree, const T* q, Workspace<T>& workspace, T* u, int begin, int end) noexcept {
  const SolveSweep<T> sweep{tree, q, workspace, u};
  const auto runs = tree.kernel_runs();
  const auto first = std::partition_point(runs.begin(), runs.end(), [&](const KernelRun& run) { return run.end <= begin; });
  const auto last = std::partition_point(first, runs.end(), [&](const KernelRun& run) { return run.begin < end; });
  const auto own = [&](KernelRun run) {
    run.begin = std::max(run.begin, begin), run.end = std::min(run.end, end);
    return run;
  };
  for (auto run = last; run != first;) {
    --run;
    dispatch_kernels(run->kind, run->variant, [&](auto tag) { sweep.template inboard<typename decltype(tag)::type>(own(*run)); });
  }
  for (auto run = first; run != last; ++run)
    dispatch_kernels(run->kind, run->variant,
                     [&](auto tag) { sweep.template outboard<typename decltype(tag)::type>(own(*run)); });
}

template void solve_mechanism<double>(const Tree&, const double*, Workspace<double>&, double*, int, int) noexcept;

}  // namespace momentree
