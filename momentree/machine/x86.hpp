#pragma once
// Machine code of x86-64 for allocated functions.
#include <momentree/machine/code.hpp>
#include <momentree/machine/function.hpp>

namespace momentree::machine {

[[nodiscard]] Bytes encode_x86(const Function& function, const Allocated& allocated, const Target& target);

/// void(const Entry* begin, const Entry* end, const void* arrays): calls each entry's function, the pointer at its begin, with
/// the entry and `arrays`. Nothing touches the registers of vectors between two calls, so that they can hand on numbers. Their
/// upper parts are zero when it returns.
[[nodiscard]] Bytes encode_x86_run(int entry_size);
/// A function for an entry that calls one of C++: the pointer at `place` in what the entry's second pointer points to.
[[nodiscard]] Bytes encode_x86_call(int place);
/// The function as one of C that is called with up to six pointers: it gets a CalledWith and the fourth of them.
[[nodiscard]] Bytes with_arguments_x86(Bytes function, const void* context);

/// Whether this processor has what the target needs: AVX2 with multiply-adds for 32 bytes, AVX-512 for 64.
[[nodiscard]] bool processor_runs(const Target& target) noexcept;

}  // namespace momentree::machine
