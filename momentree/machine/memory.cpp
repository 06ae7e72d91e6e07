#include <momentree/machine/memory.hpp>

#include <algorithm>

#if defined(__linux__) && defined(__x86_64__)
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>

namespace momentree::machine {

namespace {
std::mutex* held_at_forks = nullptr;
}  // namespace

void hold_at_forks(std::mutex& mutex) noexcept {
  held_at_forks = &mutex;
  ::pthread_atfork([] { held_at_forks->lock(); }, [] { held_at_forks->unlock(); }, [] { held_at_forks->unlock(); });
}

bool CodeMemory::map(std::size_t least) noexcept {
  constexpr std::size_t block = 1 << 20;
  const std::size_t size = (least + block - 1) / block * block;
  constexpr unsigned executable = 0x10;  // MFD_EXEC, of Linux 6.3
  int file = ::memfd_create("momentree-steps", MFD_CLOEXEC | executable);
  if (file < 0) file = ::memfd_create("momentree-steps", MFD_CLOEXEC);
  if (file < 0) return false;
  void *written = MAP_FAILED, *executed = MAP_FAILED;
  if (::ftruncate(file, static_cast<off_t>(size)) == 0) {
    written = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    executed = ::mmap(nullptr, size, PROT_READ | PROT_EXEC, MAP_SHARED, file, 0);
  }
  ::close(file);
  const bool both = written != MAP_FAILED && executed != MAP_FAILED;
  // A forked process shares the memory: it executes the code, and can't change it.
  if (!both || ::madvise(written, size, MADV_DONTFORK) != 0) {
    if (written != MAP_FAILED) ::munmap(written, size);
    if (executed != MAP_FAILED) ::munmap(executed, size);
    return false;
  }
  written_ = static_cast<std::uint8_t*>(written), executed_ = static_cast<const std::uint8_t*>(executed);
  used_ = 0, size_ = size, process_ = ::getpid();
  return true;
}

const std::uint8_t* CodeMemory::put(std::span<const std::uint8_t> bytes) noexcept {
  if ((bytes.size() > size_ - used_ || process_ != ::getpid()) && !map(bytes.size())) return nullptr;
  const std::uint8_t* const at = executed_ + used_;
  std::memcpy(written_ + used_, bytes.data(), bytes.size());
  used_ = std::min(size_, (used_ + bytes.size() + 63) / 64 * 64);
  return at;
}

}  // namespace momentree::machine

#else

namespace momentree::machine {

void hold_at_forks(std::mutex&) noexcept {}
const std::uint8_t* CodeMemory::put(std::span<const std::uint8_t>) noexcept { return nullptr; }

}  // namespace momentree::machine

#endif
