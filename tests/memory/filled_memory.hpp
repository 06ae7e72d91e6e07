#pragma once
// Memory of this program comes filled with a pattern, so that tests see what reads it before anything was written there.
#include <cstdint>

namespace momentree::memory {

/// What `operator new` fills memory with, eight bytes at a time.
enum class Fill : std::uint64_t {
  zeros = 0,
  quiet = 0xffffffffffffffff,    ///< NaN, as double and as float; −1, as an integer
  doubles = 0x7ff4dead7ff4dead,  ///< a signalling NaN: arithmetic on it raises FE_INVALID
  floats = 0x7fa0dead7fa0dead,   ///< the same for float
};

/// From now on; nothing happens under valgrind, which itself knows what was written: see `off`.
void fill_with(Fill fill);
/// True where MOMENTREE_MEMORY_FILL is "off": memory is left as it comes.
bool off();

/// Fills with a pattern while it lives, and with zeros after that.
class Filled {
 public:
  explicit Filled(Fill fill) { fill_with(fill); }
  Filled(const Filled&) = delete;
  Filled& operator=(const Filled&) = delete;
  ~Filled() { fill_with(Fill::zeros); }
};

/// Whether anything computed with a signalling NaN since `watch`. Moving one from place to place is no computation.
void watch();
bool signalled();

}  // namespace momentree::memory
