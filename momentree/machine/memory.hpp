#pragma once
// Memory for machine code. It is mapped twice: where it is executed it can't be written.
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

namespace momentree::machine {

/// Makes fork() wait for the mutex, which is then free in both processes. For one mutex.
void keep_free_in_children(std::mutex& mutex) noexcept;

/// With MOMENTREE_PERF_MAP in the environment, /tmp/perf-PID.map has the names of functions, which perf reads: adds one.
void name_for_profilers(const void* code, std::size_t size, const char* name) noexcept;

/// Code memory of this process. Not thread-safe.
class CodeMemory {
 public:
  /// It is mapped in multiples of a block of bytes.
  explicit CodeMemory(std::size_t block = 1 << 20) : block_(block) {}
  CodeMemory(const CodeMemory&) = delete;
  CodeMemory& operator=(const CodeMemory&) = delete;
  ~CodeMemory();

  /// Puts bytes at a multiple of 64 where they can be executed; null if the system refuses such memory.
  [[nodiscard]] const std::uint8_t* put(std::span<const std::uint8_t> bytes) noexcept;

 private:
  bool map(std::size_t least) noexcept;

  struct Block {
    std::uint8_t* written;
    const std::uint8_t* executed;
    std::size_t size;
    long generation;
  };
  std::size_t block_;
  std::vector<Block> blocks_;
  std::uint8_t* written_ = nullptr;
  const std::uint8_t* executed_ = nullptr;
  std::size_t used_ = 0, size_ = 0;
  long generation_ = 0;  ///< which process can write there: a child has memory of its own for new code
};

}  // namespace momentree::machine
