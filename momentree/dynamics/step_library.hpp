#pragma once
// The steps of this process as machine code. Each is made once, and kept: joints that are made and placed alike share it.
#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <span>

#include <momentree/derive/step.hpp>
#include <momentree/machine/memory.hpp>
#include <momentree/machine/x86.hpp>

namespace momentree {

/// A step and its machine code, for every way to hand on numbers that was needed.
struct CompiledStep {
  static constexpr std::size_t ways = 8;  ///< of one pass

  explicit CompiledStep(const derive::StepKey& key) : step(key) {}
  derive::Step step;
  std::array<std::array<std::atomic<StepFunction>, ways>, derive::Step::passes> functions{};
};

class StepLibrary {
 public:
  /// The only one. Functions that it returns live as long as the process.
  static StepLibrary& of_process();

  /// Whether there is machine code here: only if the variable MOMENTREE_MACHINE of the environment is 1, and not on other
  /// processors or where the system refuses executable memory.
  [[nodiscard]] bool available() const noexcept { return available_; }
  /// The steps of a key; null if there is no memory, or if there are very many others. Thread-safe.
  [[nodiscard]] CompiledStep* get(const derive::StepKey& key) noexcept;
  /// A pass of a step; null if there is no memory for it. Thread-safe.
  [[nodiscard]] StepFunction function(CompiledStep& step, std::size_t pass, const derive::Handing& how) noexcept;
  /// A function for an entry whose constants begin with a StepFunction for each pass: calls that of this pass.
  [[nodiscard]] StepFunction call_of(std::size_t pass) const noexcept { return calls_[pass]; }
  /// Calls the steps of all entries in turn.
  void run(std::span<const StepEntry> entries, const StepArrays& arrays) const noexcept {
    run_(entries.data(), entries.data() + entries.size(), &arrays);
  }

 private:
  StepLibrary();
  template <class F>
  F put(const machine::Bytes& bytes) noexcept;

  machine::Target target_{};
  bool available_ = false;
  std::mutex mutex_;
  machine::CodeMemory memory_;
  void (*run_)(const StepEntry*, const StepEntry*, const StepArrays*) = nullptr;
  std::array<StepFunction, derive::Step::passes> calls_{};
  std::map<derive::StepKey, std::unique_ptr<CompiledStep>> steps_;
};

}  // namespace momentree
