#pragma once
// Fills new memory of this program with a pattern, so that tests detect reads of memory that was never written.
#include <cstdint>

namespace momentree::memory {

/// The pattern with which `operator new` fills memory, eight bytes at a time.
enum class Fill : std::uint64_t {
  zeros = 0,
  quiet = 0xffffffffffffffff,    ///< NaN as double and as float; −1 as an integer
  doubles = 0x7ff4dead7ff4dead,  ///< a signalling NaN: arithmetic on it raises FE_INVALID
  floats = 0x7fa0dead7fa0dead,   ///< the same for float
};

/// From now on; does nothing under valgrind, which itself tracks writes: see `off`.
void fill_with(Fill fill);
/// True if MOMENTREE_MEMORY_FILL is "off": memory is not filled.
bool off();

/// Fills with a pattern during its lifetime, and with zeros after that.
class Filled {
 public:
  explicit Filled(Fill fill) { fill_with(fill); }
  Filled(const Filled&) = delete;
  Filled& operator=(const Filled&) = delete;
  ~Filled() { fill_with(Fill::zeros); }
};

/// Whether arithmetic used a signalling NaN since `watch`. Copying one does not count.
void watch();
bool signalled();

}  // namespace momentree::memory
