#pragma once
// The steps of this process as machine code. Each is made once, and kept: joints that are made and placed alike share it.
#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

#include <momentree/derive/step.hpp>
#include <momentree/dynamics/steps/step_scalar.hpp>
#include <momentree/machine/memory.hpp>
#include <momentree/machine/native.hpp>

namespace momentree {

/// A step and its machine code, for every width and every way to hand on numbers that was needed.
struct CompiledStep {
  static constexpr std::size_t widths = 7, ways = 8;

  explicit CompiledStep(const derive::StepKey& of) : key(of), step(of) {}
  derive::StepKey key;
  derive::Step step;
  std::array<std::array<std::array<std::atomic<StepFunction>, ways>, derive::Step::most_passes>, widths> functions{};
};

class StepLibrary {
 public:
  /// The only one. Functions that it returns live as long as the process.
  static StepLibrary& of_process();

  /// Whether there is machine code here: not on other processors, not where the system refuses executable memory, and not if
  /// the variable MOMENTREE_MACHINE of the environment is 0.
  [[nodiscard]] bool available(StepWidth width) const noexcept { return targets_[place_of(width)].has_value(); }
  /// The steps of a key; null if there are very many others. Thread-safe. Throws std::bad_alloc.
  [[nodiscard]] CompiledStep* get(const derive::StepKey& key);
  /// A pass of a step; null if there is no executable memory for it. Thread-safe. Throws std::bad_alloc.
  [[nodiscard]] StepFunction function(CompiledStep& step, StepWidth width, std::size_t pass, const derive::Handing& how);
  /// A function for an entry whose constants begin with a StepFunction for each pass: calls that of this pass.
  [[nodiscard]] StepFunction call_of(std::size_t pass) const noexcept { return calls_[pass]; }
  /// Calls the steps of all entries in turn.
  void run(std::span<const StepEntry> entries, const StepArrays& arrays) const noexcept {
    run_(entries.data(), entries.data() + entries.size(), &arrays);
  }

 private:
  StepLibrary();
  static std::size_t place_of(StepWidth width) { return static_cast<std::size_t>(width); }
  template <class F>
  F put(const machine::Bytes& bytes) noexcept;

  std::array<std::optional<machine::Target>, CompiledStep::widths + 1> targets_{};  ///< by StepWidth
  std::mutex mutex_;
  machine::CodeMemory memory_;
  void (*run_)(const StepEntry*, const StepEntry*, const StepArrays*) = nullptr;
  StepFunctions calls_{};
  std::map<derive::StepKey, std::unique_ptr<CompiledStep>> steps_;
};

}  // namespace momentree
