#include <momentree/machine/native.hpp>

namespace momentree::machine {

std::optional<Target> native_target(int lanes, int number) noexcept {
  Target target{.lanes = lanes, .number = number};
#ifdef __aarch64__
  if (lanes > 1 && target.vector() != 16) return std::nullopt;
  target.registers = arm64_registers;
  return target;
#else
  Target wide = target;
  wide.registers = 32, wide.avx512 = true;
  if (lanes > 1 && target.vector() < 32) return std::nullopt;
  if (processor_runs(wide)) return wide;
  return processor_runs(target) ? std::optional(target) : std::nullopt;
#endif
}

}  // namespace momentree::machine
