#include <momentree/generate/kernel_cache.hpp>

#include <chrono>
#include <mutex>
#include <unordered_map>
#include <utility>

#include <momentree/generate/compiler.hpp>
#include <momentree/generate/fingerprint.hpp>
#include <momentree/generate/loop_kernel.hpp>
#include <momentree/generate/source.hpp>

namespace momentree {

struct KernelCache::Impl {
  struct Code {
    Library library;        // keeps the function loaded
    GeneratedRates rates;   // one of them, or none
    std::vector<int> rows;  // that `rates` refers to
    bool any() const { return rates.momenta != nullptr || rates.velocities != nullptr || rates.loops != nullptr; }
  };
  explicit Impl(KernelCacheOptions how) : options(std::move(how)), compiler(find_compiler(options.compiler)) {
    if (compiler.empty())
      message = options.compiler.empty() ? "no C++ compiler was found: name one in MOMENTREE_CXX"
                                         : "the compiler '" + options.compiler + "' was not found";
  }

  GeneratedRates leave(std::string why) {
    ++statistics.left;
    explain(std::move(why));
    return {};
  }

  Code make(const Tree& tree, Variables variables, std::span<const int> rows) {
    const auto without = [this](std::string why) { return Code{{}, leave(std::move(why)), {}}; };
    if (statistics.compiled + statistics.failed >= options.most_topologies)
      return without("more than " + std::to_string(options.most_topologies) + " topologies are not compiled");
    // Every DoF takes more than ten operations: models that are far too large are not even written as expressions.
    const long most = options.most_operations * (tree.has_loops() ? 2 : 1);
    const bool huge = tree.nv() > most / 10;
    const bool momenta = variables == Variables::momenta;
    if (tree.has_loops() && ++choices[fingerprint(tree, variables, {})] > options.most_choices)
      return without("more than " + std::to_string(options.most_choices) +
                     " choices of independent equations of closed loops are not compiled for one topology");
    const KernelExpressions kernel = huge               ? KernelExpressions()
                                     : tree.has_loops() ? loop_expressions(tree, rows)
                                     : momenta          ? kernel_expressions(tree)
                                                        : velocity_expressions(tree);
    if (const long operations = kernel.operations().total(); huge || operations > most)
      return without("an evaluation of more than " + std::to_string(most) + " operations is not compiled");
    std::string why;
    Code code{compile_library(compiler, kernel_source(kernel), why), {}, {}};
    const char* const name = momenta ? "kernel_rates" : "kernel_accelerations";
    void* const symbol = code.library.symbol(name);
    if (tree.has_loops())
      code.rates.loops = reinterpret_cast<LoopRatesFunction>(symbol), code.rows.assign(rows.begin(), rows.end());
    else if (momenta)
      code.rates.momenta = reinterpret_cast<RatesFunction>(symbol);
    else
      code.rates.velocities = reinterpret_cast<VelocityRatesFunction>(symbol);
    ++(code.any() ? statistics.compiled : statistics.failed);
    if (!code.any()) explain(why.empty() ? "the compiler left out " + std::string(name) : why);
    return code;
  }

  GeneratedRates find(const Tree& tree, Variables variables, std::span<const int> rows) {
    const std::lock_guard lock(mutex);
    if (compiler.empty()) return {};
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
    } else if (place->second.any()) {
      ++statistics.found_again;
    }
    statistics.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return place->second.rates;
  }

  void explain(std::string why) {
    if (message.empty()) message = std::move(why);
  }

  const KernelCacheOptions options;
  const std::vector<std::string> compiler;
  std::mutex mutex;
  std::unordered_map<std::string, Code> codes;    // by fingerprint
  std::unordered_map<std::string, long> choices;  // of rows, by the fingerprint of the topology alone
  KernelCacheStatistics statistics;
  std::string message;
};

KernelCache::KernelCache(KernelCacheOptions options) : impl_(std::make_shared<Impl>(std::move(options))) {}

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
std::vector<std::string> KernelCache::compiler() const { return impl_->compiler; }

}  // namespace momentree
