#pragma once

namespace momentree {

/// Instruction sets for which kernels of packs are compiled, each in its own source file. The set is part of a pack's type, so
/// that no function for one set is linked into code for another.
enum class Isa : unsigned char {
  baseline,  ///< that of the whole library: SSE2 on x86-64, NEON on ARM
  avx2,      ///< AVX2 and FMA
  avx512     ///< AVX-512F, DQ, VL
};

}  // namespace momentree
