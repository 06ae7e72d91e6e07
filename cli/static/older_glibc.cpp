// For MOMENTREE_STATIC: functions that Debian 12 takes from newer versions of glibc than are needed. With these, programs run
// with glibc 2.34 on x86-64. dlfcn.h declares _dl_find_object since 2.35.
#include <dlfcn.h>
#include <link.h>
#include <sys/random.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>

// Random numbers of expat and libstdc++, from glibc 2.36.
extern "C" void arc4random_buf(void* buffer, std::size_t size) noexcept {
  auto* next = static_cast<unsigned char*>(buffer);
  while (size > 0) {
    const ssize_t count = getrandom(next, size, 0);
    if (count < 0) std::abort();  // as glibc does; below 256 bytes a signal does not interrupt it
    next += count;
    size -= static_cast<std::size_t>(count);
  }
}

extern "C" std::uint32_t arc4random() noexcept {
  std::uint32_t number = 0;
  arc4random_buf(&number, sizeof number);
  return number;
}

#if defined(__x86_64__) && defined(__GLIBC__)

// glibc 2.35 has a new hypot that does not set errno as SVID asks; the old one computes the same. --wrap=hypot calls this
// instead.
extern "C" double momentree_old_hypot(double x, double y) noexcept;
__asm__(".symver momentree_old_hypot,hypot@GLIBC_2.2.5");
extern "C" double __wrap_hypot(double x, double y) noexcept { return momentree_old_hypot(x, y); }

#ifdef DLFO_STRUCT_HAS_EH_DBASE

// Where the unwinder of GCC 12 finds the table of an address, from glibc 2.35: as older unwinders do it.
namespace {

struct Search {
  ElfW(Addr) address;
  dl_find_object* result;
};

int look_into(dl_phdr_info* object, std::size_t /*size*/, void* data) {
  const auto& search = *static_cast<Search*>(data);
  const ElfW(Phdr)* table = nullptr;
  ElfW(Addr) first = 0, end = 0;
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const ElfW(Phdr)& part = object->dlpi_phdr[i];
    const ElfW(Addr) start = object->dlpi_addr + part.p_vaddr;
    if (part.p_type == PT_LOAD && search.address >= start && search.address - start < part.p_memsz)
      first = start, end = start + part.p_memsz;
    else if (part.p_type == PT_GNU_EH_FRAME)
      table = &part;
  }
  if (end == 0 || table == nullptr) return 0;
  *search.result = {};
  search.result->dlfo_map_start = reinterpret_cast<void*>(first);
  search.result->dlfo_map_end = reinterpret_cast<void*>(end);
  search.result->dlfo_eh_frame = reinterpret_cast<void*>(object->dlpi_addr + table->p_vaddr);
  return 1;
}

}  // namespace

extern "C" int _dl_find_object(void* address, dl_find_object* result) noexcept {
  Search search{reinterpret_cast<ElfW(Addr)>(address), result};
  return dl_iterate_phdr(look_into, &search) != 0 ? 0 : -1;
}

#endif
#endif
