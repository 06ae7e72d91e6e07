#pragma once
// The kernels' accumulators stay in registers only where every piece of a link's work is inlined into one loop.
#define MOMENTREE_INLINE [[gnu::always_inline]] inline
/// The same for a lambda, behind its parameters.
#define MOMENTREE_INLINE_LAMBDA __attribute__((always_inline))
