#include <momentree/dynamics/steps/step_library.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

namespace momentree {

StepLibrary& StepLibrary::of_process() {
  static auto* const library = new StepLibrary;  // never destroyed: threads may still step while the process ends
  return *library;
}

StepLibrary::StepLibrary() {
  const char* const wanted = std::getenv("MOMENTREE_MACHINE");
  if (wanted != nullptr && std::strcmp(wanted, "0") == 0) return;
  if (!machine::native_target(1, 8)) return;
  run_ = put<decltype(run_)>(machine::encode_run(sizeof(StepEntry)));
  bool any = run_ != nullptr;
  for (std::size_t pass = 0; pass < calls_.size(); ++pass) {
    calls_[pass] = put<StepFunction>(machine::encode_call(static_cast<int>(pass * sizeof(StepFunction))));
    any = any && calls_[pass] != nullptr;
  }
  if (!any) return;
  const auto add = [&](StepWidth width, int lanes, int number) {
    targets_[place_of(width)] = machine::native_target(lanes, number);
  };
  add(StepWidth::one, 1, 8), add(StepWidth::double_2, 2, 8), add(StepWidth::double_4, 4, 8), add(StepWidth::double_8, 8, 8);
  add(StepWidth::float_4, 4, 4), add(StepWidth::float_8, 8, 4), add(StepWidth::float_16, 16, 4);
  machine::keep_free_in_children(mutex_);
}

template <class F>
F StepLibrary::put(const machine::Bytes& bytes) noexcept {
  const std::uint8_t* const at = memory_.put(bytes.all);
  return at == nullptr ? nullptr : reinterpret_cast<F>(const_cast<std::uint8_t*>(at) + bytes.entry);
}

CompiledStep* StepLibrary::get(const derive::StepKey& key) {
  const std::lock_guard lock(mutex_);
  const auto known = steps_.find(key);
  if (known != steps_.end()) return known->second.get();
  constexpr std::size_t most = 8192;  // of some 80 kB each
  if (steps_.size() >= most && !derive::is_general(key)) return nullptr;
  return steps_.emplace(key, std::make_unique<CompiledStep>(key)).first->second.get();
}

StepFunction StepLibrary::function(CompiledStep& step, StepWidth width, std::size_t pass, const derive::Handing& how) {
  const std::size_t way = how.in_registers + 2u * how.to_registers + 4u * (how.adds || how.to_memory);
  std::atomic<StepFunction>& function = step.functions[place_of(width) - 1][pass][way];
  if (const StepFunction known = function.load(std::memory_order_acquire); known != nullptr) return known;
  const std::lock_guard lock(mutex_);
  if (const StepFunction known = function.load(std::memory_order_relaxed); known != nullptr) return known;
  const machine::Target& target = *targets_[place_of(width)];
  const machine::Function text = step.step.function(pass, how, target);
  const machine::Bytes bytes = machine::encode(text, machine::allocate(text, target), target);
  const StepFunction made = put<StepFunction>(bytes);
  constexpr const char* places[] = {"inner", "leaf", "root", "single"};
  char name[80];
  std::snprintf(name, sizeof name, "%s, %s, %s, pass %zu", info(step.key.kind).name,
                places[static_cast<std::size_t>(step.key.place)], name_of(step.key.passes), pass + 1);
  if (made != nullptr) machine::name_for_profilers(reinterpret_cast<const void*>(made), bytes.all.size() - bytes.entry, name);
  function.store(made, std::memory_order_release);
  return made;
}

}  // namespace momentree
