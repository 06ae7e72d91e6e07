#include <tests/memory/filled_memory.hpp>

#include <atomic>
#include <cfenv>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string_view>

namespace momentree::memory {

namespace {

std::atomic<std::uint64_t> pattern{0};

void* filled(void* memory, std::size_t size) {
  if (memory == nullptr) throw std::bad_alloc();
  if (off()) return memory;
  const std::uint64_t word = pattern;
  auto* const bytes = static_cast<unsigned char*>(memory);
  for (std::size_t i = 0; i < size; i += sizeof word)
    std::memcpy(bytes + i, &word, size - i < sizeof word ? size - i : sizeof word);
  return memory;
}

}  // namespace

bool off() {
  static const bool is_off = [] {
    const char* const given = std::getenv("MOMENTREE_MEMORY_FILL");
    return given != nullptr && std::string_view(given) == "off";
  }();
  return is_off;
}

void fill_with(Fill fill) { pattern = static_cast<std::uint64_t>(fill); }

void watch() { std::feclearexcept(FE_ALL_EXCEPT); }
bool signalled() { return std::fetestexcept(FE_INVALID) != 0; }

}  // namespace momentree::memory

using momentree::memory::filled;

void* operator new(std::size_t size) { return filled(std::malloc(size > 0 ? size : 1), size); }
void* operator new[](std::size_t size) { return operator new(size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto a = static_cast<std::size_t>(alignment);
  return filled(std::aligned_alloc(a, (size + a - 1) / a * a), size);
}
void* operator new[](std::size_t size, std::align_val_t alignment) { return operator new(size, alignment); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
