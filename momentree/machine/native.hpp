#pragma once
// Machine code for the processor that this program runs on.
#include <optional>

#include <momentree/machine/arm64.hpp>
#include <momentree/machine/x86.hpp>

namespace momentree::machine {

/// For so many worlds at once, whose numbers have so many bytes; nothing if it has no such registers.
[[nodiscard]] std::optional<Target> native_target(int lanes, int number) noexcept;

#ifdef __aarch64__
inline constexpr auto* encode = encode_arm64;
inline constexpr auto *encode_run = encode_arm64_run, *encode_call = encode_arm64_call;
inline constexpr auto* with_arguments = with_arguments_arm64;
#else
inline constexpr auto* encode = encode_x86;
inline constexpr auto *encode_run = encode_x86_run, *encode_call = encode_x86_call;
inline constexpr auto* with_arguments = with_arguments_x86;
#endif
/// Numbers that a function can have in its own memory, and in each array: AArch64 has short offsets, and a stack is checked page
/// by page. And bytes of its code and constants.
inline constexpr int most_numbers = 4000, most_bytes = 1 << 20;

}  // namespace momentree::machine
