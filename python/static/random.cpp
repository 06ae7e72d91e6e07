// In wheels, expat's source of random numbers: Debian's expat takes arc4random_buf from glibc 2.36, and all else that the
// extension calls is in glibc 2.35, which Ubuntu 22.04 has.
#include <sys/random.h>

#include <cstddef>
#include <cstdlib>

extern "C" void arc4random_buf(void* buffer, std::size_t size) noexcept {
  auto* next = static_cast<unsigned char*>(buffer);
  while (size > 0) {
    const ssize_t count = getrandom(next, size, 0);
    if (count < 0) std::abort();  // as glibc does; below 256 bytes a signal does not interrupt it
    next += count;
    size -= static_cast<std::size_t>(count);
  }
}
