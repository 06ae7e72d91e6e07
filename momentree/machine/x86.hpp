#pragma once
// Machine code of x86-64 for allocated functions.
#include <cstdint>
#include <vector>

#include <momentree/machine/function.hpp>

namespace momentree::machine {

/// Position-independent: constants, then instructions. The code has the C signature void(const void*, const void*): it finds its
/// bases in these arguments.
struct Bytes {
  std::vector<std::uint8_t> all;  ///< to be put at a multiple of 64
  std::size_t entry = 0;          ///< where the first instruction is
};
[[nodiscard]] Bytes encode_x86(const Function& function, const Allocated& allocated, const Target& target);

/// void(const Entry* begin, const Entry* end, const void* arrays): calls each entry's function, the pointer at its begin, with
/// the entry and `arrays`. Nothing touches the registers of vectors between two calls, so that they can hand on numbers.
[[nodiscard]] Bytes encode_x86_run(int entry_size);
/// A function for an entry that calls one of C++: the pointer at `place` in what the entry's second pointer points to.
[[nodiscard]] Bytes encode_x86_call(int place);

/// What this processor has: AVX2 with multiply-adds for up to 4 worlds at once, AVX-512 for up to 8. False: it has neither.
[[nodiscard]] bool processor_runs(const Target& target) noexcept;

}  // namespace momentree::machine
