#pragma once
// The kernels' accumulators stay in registers only where every piece of a link's work is inlined into one loop.
#define MOMENTREE_INLINE [[gnu::always_inline]] inline
