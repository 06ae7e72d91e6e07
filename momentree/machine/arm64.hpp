#pragma once
// Machine code of AArch64 for allocated functions: one world, or as many as fill 16 bytes.
#include <momentree/machine/code.hpp>
#include <momentree/machine/function.hpp>

namespace momentree::machine {

/// Registers that an allocation may use: the encoder needs the others.
inline constexpr int arm64_registers = 30;

[[nodiscard]] Bytes encode_arm64(const Function& function, const Allocated& allocated, const Target& target);
[[nodiscard]] Bytes encode_arm64_run(int entry_size);
[[nodiscard]] Bytes encode_arm64_call(int place);
[[nodiscard]] Bytes with_arguments_arm64(Bytes function, const void* context);

}  // namespace momentree::machine
