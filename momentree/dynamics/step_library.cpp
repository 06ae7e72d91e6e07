#include <momentree/dynamics/step_library.hpp>

#include <cstdlib>
#include <cstring>
#include <new>

namespace momentree {

StepLibrary& StepLibrary::of_process() {
  static auto* const library = new StepLibrary;  // never destroyed: threads may still step while the process ends
  return *library;
}

StepLibrary::StepLibrary() {
#ifdef MOMENTREE_DETERMINISTIC  // the same bits on every processor: by the steps that every processor has
  return;
#endif
  const char* const wanted = std::getenv("MOMENTREE_MACHINE");
  if (wanted == nullptr || std::strcmp(wanted, "1") != 0) return;
  machine::Target wide = target_;
  wide.registers = 32;
  if (machine::processor_runs(wide)) target_ = wide;
  if (!machine::processor_runs(target_)) return;
  run_ = put<decltype(run_)>(machine::encode_x86_run(sizeof(StepEntry)));
  available_ = run_ != nullptr;
  for (std::size_t pass = 0; pass < calls_.size(); ++pass) {
    calls_[pass] = put<StepFunction>(machine::encode_x86_call(static_cast<int>(pass * sizeof(StepFunction))));
    available_ = available_ && calls_[pass] != nullptr;
  }
  if (available_) machine::keep_free_in_children(mutex_);
}

template <class F>
F StepLibrary::put(const machine::Bytes& bytes) noexcept {
  const std::uint8_t* const at = memory_.put(bytes.all);
  return at == nullptr ? nullptr : reinterpret_cast<F>(const_cast<std::uint8_t*>(at) + bytes.entry);
}

CompiledStep* StepLibrary::get(const derive::StepKey& key) noexcept try {
  const std::lock_guard lock(mutex_);
  const auto known = steps_.find(key);
  if (known != steps_.end()) return known->second.get();
  constexpr std::size_t most = 1024;  // of some 50 kB each
  if (steps_.size() == most) return nullptr;
  return steps_.emplace(key, std::make_unique<CompiledStep>(key)).first->second.get();
} catch (const std::bad_alloc&) {
  return nullptr;
}

StepFunction StepLibrary::function(CompiledStep& step, std::size_t pass, const derive::Handing& how) noexcept try {
  const std::size_t way = how.in_registers + 2u * how.to_registers + 4u * (how.adds || how.to_memory);
  std::atomic<StepFunction>& function = step.functions[pass][way];
  if (const StepFunction known = function.load(std::memory_order_acquire); known != nullptr) return known;
  const std::lock_guard lock(mutex_);
  if (const StepFunction known = function.load(std::memory_order_relaxed); known != nullptr) return known;
  const machine::Function text = step.step.function(pass, how, target_);
  const StepFunction made = put<StepFunction>(machine::encode_x86(text, machine::allocate(text, target_), target_));
  function.store(made, std::memory_order_release);
  return made;
} catch (const std::bad_alloc&) {
  return nullptr;
}

}  // namespace momentree
