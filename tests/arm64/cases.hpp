#pragma once
// The file that write_cases makes for run_cases: for each case a header, then code, an entry, and the memory before and after.
#include <cstdint>

namespace momentree::arm64_cases {

struct Case {
  std::uint64_t code, begin;   ///< bytes of the code, and where its first instruction is
  std::uint64_t block, array;  ///< bytes of all arrays, and of one of them; the last one has the constants
  std::uint64_t arrays;        ///< how many the code is called with
};

}  // namespace momentree::arm64_cases
