#pragma once
// Machine code of a function.
#include <cstddef>
#include <cstdint>
#include <vector>

namespace momentree::machine {

/// Position-independent: constants, then instructions. The code has the C signature void(const void*, const void*): it finds its
/// bases in these arguments.
struct Bytes {
  std::vector<std::uint8_t> all;  ///< to be put at a multiple of 64
  std::size_t entry = 0;          ///< where the first instruction is
};

/// The first argument of functions that were made by with_arguments.
struct CalledWith {
  const void* arguments[6];
  const void* context;
  std::int64_t zero;  ///< 0: the offset of bases in the second argument
};

}  // namespace momentree::machine
