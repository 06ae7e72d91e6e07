#pragma once
// The kernels' accumulators stay in registers only if all functions of a link are inlined into one loop. If speed does not matter
// (counting operations, symbols), MOMENTREE_MAY_CALL allows calls and compiles in a fifth of the time. Such functions have a tag
// in their linker names, so that a program with both never uses one for the other.
#ifdef MOMENTREE_MAY_CALL
#define MOMENTREE_INLINE [[gnu::abi_tag("may_call")]] inline
#define MOMENTREE_INLINE_LAMBDA
#else
#define MOMENTREE_INLINE [[gnu::always_inline]] inline
/// The same for a lambda, after its parameters.
#define MOMENTREE_INLINE_LAMBDA __attribute__((always_inline))
#endif
