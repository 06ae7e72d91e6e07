#include <momentree/machine/memory.hpp>

#include <algorithm>

#if defined(__linux__) && (defined(__x86_64__) || defined(__aarch64__))
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

namespace momentree::machine {

namespace {
std::mutex* kept_free = nullptr;
long generation = 0;  // the first process is 0, its children are 1, …
}  // namespace

void keep_free_in_children(std::mutex& mutex) noexcept {
  kept_free = &mutex;
  ::pthread_atfork([] { kept_free->lock(); }, [] { kept_free->unlock(); }, [] { kept_free->unlock(); });
}

void name_for_profilers(const void* code, std::size_t size, const char* name) noexcept {
  static const bool wanted = std::getenv("MOMENTREE_PERF_MAP") != nullptr;
  if (!wanted) return;
  char path[40];
  std::snprintf(path, sizeof path, "/tmp/perf-%ld.map", static_cast<long>(::getpid()));
  const int map = ::open(path, O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0600);
  if (map < 0) return;
  ::dprintf(map, "%zx %zx %s\n", reinterpret_cast<std::size_t>(code), size, name);
  ::close(map);
}

bool CodeMemory::map(std::size_t least) noexcept {
  static const bool counted = ::pthread_atfork(nullptr, nullptr, [] { ++generation; }) == 0;
  if (!counted) return false;
  const std::size_t size = (least + block_ - 1) / block_ * block_;
  try {
    blocks_.reserve(blocks_.size() + 1);
  } catch (const std::bad_alloc&) {
    return false;
  }
  void* written = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  void* executed = written == MAP_FAILED ? MAP_FAILED : ::mremap(written, 0, size, MREMAP_MAYMOVE);  // the same memory
  if (written != MAP_FAILED && executed == MAP_FAILED) {  // emulators and sandboxes do not map memory twice; they map files
    ::munmap(written, size);
    written = MAP_FAILED;
    if (const int file = ::memfd_create("momentree", MFD_CLOEXEC); file >= 0) {
      const auto map_file = [&](int protection) { return ::mmap(nullptr, size, protection, MAP_SHARED, file, 0); };
      if (::ftruncate(file, static_cast<off_t>(size)) == 0)
        written = map_file(PROT_READ | PROT_WRITE), executed = map_file(PROT_READ);
      ::close(file);
    }
  }
  const bool both = executed != MAP_FAILED && ::mprotect(executed, size, PROT_READ | PROT_EXEC) == 0;
  // A forked process shares the memory: it executes the code, and can't change it.
  if (!both || ::madvise(written, size, MADV_DONTFORK) != 0) {
    if (written != MAP_FAILED) ::munmap(written, size);
    if (executed != MAP_FAILED) ::munmap(executed, size);
    return false;
  }
  written_ = static_cast<std::uint8_t*>(written), executed_ = static_cast<const std::uint8_t*>(executed);
  used_ = 0, size_ = size, generation_ = generation;
  blocks_.push_back({written_, executed_, size_, generation_});
  return true;
}

CodeMemory::~CodeMemory() {
  for (const Block& one : blocks_) {
    ::munmap(const_cast<std::uint8_t*>(one.executed), one.size);
    if (one.generation == generation) ::munmap(one.written, one.size);  // else a parent's, which is not mapped here
  }
}

const std::uint8_t* CodeMemory::put(std::span<const std::uint8_t> bytes) noexcept {
  if ((bytes.size() > size_ - used_ || generation_ != generation) && !map(bytes.size())) return nullptr;
  const std::uint8_t* const at = executed_ + used_;
  std::memcpy(written_ + used_, bytes.data(), bytes.size());
  char* const begin = reinterpret_cast<char*>(const_cast<std::uint8_t*>(at));  // instructions may be cached apart from data
  __builtin___clear_cache(begin, begin + bytes.size());
  used_ = std::min(size_, (used_ + bytes.size() + 63) / 64 * 64);
  return at;
}

}  // namespace momentree::machine

#else

namespace momentree::machine {

void keep_free_in_children(std::mutex&) noexcept {}
void name_for_profilers(const void*, std::size_t, const char*) noexcept {}
CodeMemory::~CodeMemory() = default;
const std::uint8_t* CodeMemory::put(std::span<const std::uint8_t>) noexcept { return nullptr; }

}  // namespace momentree::machine

#endif
