#pragma once
// The kernels' accumulators stay in registers only where every piece of a link's work is inlined into one loop. Where nobody
// waits for the result (operations counted, symbols, the tests' own instances), pieces may be called: MOMENTREE_MAY_CALL compiles
// in a fifth of the time.
#ifdef MOMENTREE_MAY_CALL
#define MOMENTREE_INLINE inline
#define MOMENTREE_INLINE_LAMBDA
#else
#define MOMENTREE_INLINE [[gnu::always_inline]] inline
/// The same for a lambda, behind its parameters.
#define MOMENTREE_INLINE_LAMBDA __attribute__((always_inline))
#endif
