#include <momentree/generate/kernel_cache.hpp>

#include <chrono>
#include <mutex>
#include <new>
#include <unordered_map>
#include <utility>

#include <momentree/dynamics/steps/step_library.hpp>
#include <momentree/generate/fingerprint.hpp>
#include <momentree/generate/loop_kernel.hpp>
#include <momentree/generate/machine_code.hpp>

namespace momentree {

struct KernelCache::Impl {
  struct Code {
    std::unique_ptr<const MachineKernel> kernel;  // keeps the function
    GeneratedRates rates;                         // one of them, or none
    std::vector<int> rows;                        // that `rates` refers to
  };
  explicit Impl(KernelCacheOptions how) : options(how) {}

  GeneratedRates leave(std::string why) {
    ++statistics.left;
    explain(std::move(why));
    return {};
  }

  Code make(const Tree& tree, Variables variables, std::span<const int> rows) {
    const auto without = [this](std::string why) { return Code{{}, leave(std::move(why)), {}}; };
    if (statistics.compiled >= options.most_topologies)
      return without("more than " + std::to_string(options.most_topologies) + " topologies have no code");
    // Every DoF takes more than ten operations: models that are far too large are not even written as expressions.
    const long most = options.most_operations * (tree.has_loops() ? 2 : 1);
    const bool huge = tree.nv() > most / 10;
    const bool momenta = variables == Variables::momenta;
    if (tree.has_loops() && ++choices[fingerprint(tree, variables, {})] > options.most_choices)
      return without("more than " + std::to_string(options.most_choices) +
                     " choices of independent equations of closed loops have no code for one topology");
    Code code;
    try {
      const KernelExpressions kernel = huge               ? KernelExpressions()
                                       : tree.has_loops() ? loop_expressions(tree, rows)
                                       : momenta          ? kernel_expressions(tree)
                                                          : velocity_expressions(tree);
      if (const long operations = kernel.operations().total(); huge || operations > most)
        return without("there is no code for evaluations of more than " + std::to_string(most) + " operations");
      code.kernel = MachineKernel::make(kernel);
    } catch (const std::bad_alloc&) {
      return without("there was too little memory to make code");
    }
    if (code.kernel == nullptr)
      return without(StepLibrary::of_process().available(StepWidth::one)
                         ? "the code would be too large, or the system refuses executable memory for it"
                         : "there is no machine code here: the system refuses it, or MOMENTREE_MACHINE=0 switches it off");
    if (tree.has_loops())
      code.rates.loops = code.kernel->loops(), code.rows.assign(rows.begin(), rows.end());
    else if (momenta)
      code.rates.momenta = code.kernel->momenta();
    else
      code.rates.velocities = code.kernel->velocities();
    ++statistics.compiled;
    return code;
  }

  GeneratedRates find(const Tree& tree, Variables variables, std::span<const int> rows) {
    const std::lock_guard lock(mutex);
    if (tree.has_loops() ? !stages_take_loop_rates(tree, variables) : !stages_take_rates(tree))
      return leave(tree.has_loops()
                       ? "stages with closed loops or couplings run the kernels themselves in momenta, and with "
                         "springs between points, contact, forces on bodies or functions"
                       : "stages with contact, forces on bodies, functions or prescribed motions run the kernels themselves");
    const auto start = std::chrono::steady_clock::now();
    const auto [place, fresh] = codes.try_emplace(fingerprint(tree, variables, rows));
    if (fresh) {
      place->second = make(tree, variables, rows);
      place->second.rates.rows = place->second.rows;
    } else if (place->second.kernel != nullptr) {
      ++statistics.found_again;
    }
    statistics.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return place->second.rates;
  }

  void explain(std::string why) {
    if (message.empty()) message = std::move(why);
  }

  const KernelCacheOptions options;
  std::mutex mutex;
  std::unordered_map<std::string, Code> codes;    // by fingerprint
  std::unordered_map<std::string, long> choices;  // of rows, by the fingerprint of the topology alone
  KernelCacheStatistics statistics;
  std::string message;
};

KernelCache::KernelCache(KernelCacheOptions options) : impl_(std::make_shared<Impl>(options)) {}

RatesProvider KernelCache::provider() const {
  return [impl = impl_](const Tree& tree, Variables variables, std::span<const int> rows) {
    return impl->find(tree, variables, rows);
  };
}
RatesFunction KernelCache::find(const Tree& tree) const { return impl_->find(tree, Variables::momenta, {}).momenta; }
VelocityRatesFunction KernelCache::find_velocities(const Tree& tree) const {
  return impl_->find(tree, Variables::velocities, {}).velocities;
}
LoopRatesFunction KernelCache::find_loops(const Tree& tree, std::span<const int> rows) const {
  return impl_->find(tree, Variables::velocities, rows).loops;
}

KernelCacheStatistics KernelCache::statistics() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->statistics;
}
std::string KernelCache::message() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->message;
}

}  // namespace momentree
