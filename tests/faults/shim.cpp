// A preloaded library that counts the program's system calls and makes one of them fail.
// FAULTS_CLASS  calls to count: one of `classes`, or "any" for all of them
// FAULTS_AT     the number of the call that fails, counted from main on; empty or 0: none
// FAULTS_ERROR  the errno; 0: a write that stops halfway
// FAULTS_STICKY 1: all later calls of the class fail, too
// FAULTS_KILL   1: instead, the process is killed before that call
// FAULTS_DISK   free space on the disk (bytes): calls that would let files grow beyond it fail
// FAULTS_NO_EXCHANGE 1: renameat2 does not support its flags, as on some file systems
// FAULTS_TRACE  a file to which each call that changes files is written
// FAULTS_LOG    a file; at the end of the process it gets a line "CLASS NUMBER SITE" for each call that was the first of its
// site, "failed SITE" for the call that failed, "live BLOCKS" (blocks that were not freed), and "calls CLASS COUNT"
// A call's site is a hash of the return addresses above it, each relative to its module.
#include <dirent.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

enum Class {
  alloc,
  open_,
  read_,
  write_,
  close_,
  sync_,
  rename_,
  remove_,
  mkdir_,
  stat_,
  folder_,
  lock_,
  truncate_,
  class_count
};
constexpr const char* classes[class_count] = {"alloc",  "open",  "read", "write",  "close", "sync",    "rename",
                                              "remove", "mkdir", "stat", "folder", "lock",  "truncate"};

std::atomic<bool> counting{false};
std::atomic<long> calls[class_count], any_calls, live;
int wanted = -2;  // a class, or −1: any
long at = 0;
int error = 0;
int depth = 8;
bool sticky = false, kills = false, no_exchange = false;
const char* log_path = nullptr;
int trace_file = -1;
std::atomic<long> disk_left{-1};  // −1: unlimited
std::uint64_t failed_site = 0;

// Sites that occurred, and their first calls; an open-addressing table without memory from malloc.
struct Seen {
  std::uint64_t site;
  long number;
  int of;
};
constexpr std::size_t table_size = 1 << 18;
Seen table[table_size];
thread_local bool inside = false;

std::uintptr_t base_of(void* address) {
  Dl_info info;
  return dladdr(address, &info) != 0 ? reinterpret_cast<std::uintptr_t>(info.dli_fbase) : 0;
}

std::uint64_t site_above() {
  void* frames[32];
  const int count = backtrace(frames, 32);
  std::uint64_t hash = 1469598103934665603u;
  for (int i = 2; i < count && i < 2 + depth; ++i)
    hash = (hash ^ (reinterpret_cast<std::uintptr_t>(frames[i]) - base_of(frames[i]))) * 1099511628211u;
  return hash | 1;
}

void remember(int of, long number, std::uint64_t site) {
  const std::uint64_t key = site * class_count + static_cast<std::uint64_t>(of) + 1;
  for (std::size_t i = key % table_size, tries = 0; tries < table_size; i = (i + 1) % table_size, ++tries) {
    if (table[i].number != 0 && (table[i].site != site || table[i].of != of)) continue;
    if (table[i].number == 0) table[i] = {site, number, of};
    return;
  }
}

/// Counts a call; returns whether it must fail.
bool fails(Class of) {
  if (!counting.load(std::memory_order_relaxed) || inside) return false;
  const long number = ++calls[of], any = ++any_calls;
  const bool counted = wanted == of || wanted == -1;
  const long here = wanted == -1 ? any : number;
  const bool hit = counted && at > 0 && (here == at || (sticky && here > at));
  if (log_path != nullptr && (at == 0 || (hit && failed_site == 0))) {
    inside = true;
    const std::uint64_t site = site_above();
    if (at == 0)
      remember(of, number, site);
    else
      failed_site = site;
    inside = false;
  }
  if (!hit) return false;
  if (kills) raise(SIGKILL);
  errno = error;
  return true;
}

template <class Function>
Function* real(Function*, const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
#define REAL(function) static auto* const next = real(&function, #function)

void write_log() {
  if (log_path == nullptr) return;
  counting = false;
  inside = true;
  const int file = static_cast<int>(syscall(SYS_openat, AT_FDCWD, log_path, O_WRONLY | O_CREAT | O_TRUNC, 0666));
  char line[160];
  const auto put = [&](int length) {
    if (syscall(SYS_write, file, line, static_cast<std::size_t>(length)) < 0) _exit(99);
  };
  for (const Seen& seen : table)
    if (seen.number != 0)
      put(std::snprintf(line, sizeof line, "%s %ld %016llx\n", classes[seen.of], seen.number,
                        static_cast<unsigned long long>(seen.site)));
  if (failed_site != 0) put(std::snprintf(line, sizeof line, "failed %016llx\n", static_cast<unsigned long long>(failed_site)));
  for (int c = 0; c < class_count; ++c) put(std::snprintf(line, sizeof line, "calls %s %ld\n", classes[c], calls[c].load()));
  put(std::snprintf(line, sizeof line, "calls any %ld\nlive %ld\n", any_calls.load(), live.load()));
  syscall(SYS_close, file);
}

void trace(const char* what, const char* one, const char* two = "") {
  if (trace_file < 0 || !counting) return;
  char line[1024];
  const int length = std::snprintf(line, sizeof line, "%s\t%s\t%s\n", what, one, two);
  if (syscall(SYS_write, trace_file, line, static_cast<std::size_t>(length)) < 0) _exit(95);
}
void trace(const char* what, int file, const char* path = "") {
  char number[16];
  std::snprintf(number, sizeof number, "%d", file);
  trace(what, number, path);
}

/// How many bytes of a write fit on the disk.
std::size_t room_for(int file, std::size_t size) {
  struct stat status {};
  if (disk_left < 0 || syscall(SYS_fstat, file, &status) != 0 || !S_ISREG(status.st_mode)) return size;
  const long at_byte = syscall(SYS_lseek, file, 0, SEEK_CUR), inside_file = status.st_size - at_byte;
  const long growth = static_cast<long>(size) - (inside_file > 0 ? inside_file : 0);
  if (growth <= 0) return size;
  const long fits = growth < disk_left ? growth : disk_left.load();
  disk_left -= fits;
  return size - static_cast<std::size_t>(growth - fits);
}

// Output is redirected here so that it can fail: the library's own streams call no replaceable function.
ssize_t put_out(void*, const char* data, size_t size) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = write(STDOUT_FILENO, data + done, size - done);
    if (count < 0) break;
    done += static_cast<std::size_t>(count);
  }
  return static_cast<ssize_t>(done);
}

void begin() {
  const auto number = [](const char* name, long otherwise) {
    const char* text = std::getenv(name);
    return text == nullptr || *text == '\0' ? otherwise : std::atol(text);
  };
  if (const char* of = std::getenv("FAULTS_CLASS")) {
    if (std::strcmp(of, "any") == 0) wanted = -1;
    for (int c = 0; c < class_count; ++c)
      if (std::strcmp(of, classes[c]) == 0) wanted = c;
  }
  at = number("FAULTS_AT", 0);
  error = static_cast<int>(number("FAULTS_ERROR", ENOSPC));
  sticky = number("FAULTS_STICKY", 0) != 0;
  depth = static_cast<int>(number("FAULTS_DEPTH", 8));
  kills = number("FAULTS_KILL", 0) != 0;
  no_exchange = number("FAULTS_NO_EXCHANGE", 0) != 0;
  log_path = std::getenv("FAULTS_LOG");
  disk_left = number("FAULTS_DISK", -1);
  if (const char* path = std::getenv("FAULTS_TRACE"))
    trace_file = static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  unsetenv("LD_PRELOAD");  // child processes are not counted
  void* frames[4];
  backtrace(frames, 4);  // loads the libraries that it needs
  cookie_io_functions_t functions = {nullptr, put_out, nullptr, nullptr};
  if (std::FILE* out = fopencookie(nullptr, "w", functions)) stdout = out;
  std::atexit(write_log);
  live = 0;
  counting = true;
}

int (*real_main)(int, char**, char**);
int counted_main(int argc, char** argv, char** environment) {
  begin();
  return real_main(argc, argv, environment);
}

// dlsym may allocate before malloc has been resolved.
alignas(16) char early[1 << 16];
std::atomic<std::size_t> early_used{0};
void* early_memory(std::size_t size) {
  const std::size_t from = early_used.fetch_add((size + 15) & ~std::size_t{15});
  if (from + size > sizeof early) _exit(98);
  return early + from;
}
bool is_early(void* memory) { return memory >= early && memory < early + sizeof early; }

struct Memory {
  void* (*malloc)(std::size_t);
  void* (*calloc)(std::size_t, std::size_t);
  void* (*realloc)(void*, std::size_t);
  void* (*aligned_alloc)(std::size_t, std::size_t);
  void (*free)(void*);
};
Memory memory;
bool resolving = false;
bool have_memory() {
  if (memory.free != nullptr) return true;
  if (resolving) return false;
  resolving = true;
  Memory found;
  found.malloc = reinterpret_cast<decltype(found.malloc)>(dlsym(RTLD_NEXT, "malloc"));
  found.calloc = reinterpret_cast<decltype(found.calloc)>(dlsym(RTLD_NEXT, "calloc"));
  found.realloc = reinterpret_cast<decltype(found.realloc)>(dlsym(RTLD_NEXT, "realloc"));
  found.aligned_alloc = reinterpret_cast<decltype(found.aligned_alloc)>(dlsym(RTLD_NEXT, "aligned_alloc"));
  found.free = reinterpret_cast<decltype(found.free)>(dlsym(RTLD_NEXT, "free"));
  memory = found;
  return true;
}
void* count_live(void* block) {
  if (block != nullptr) ++live;
  return block;
}

}  // namespace

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(void), void (*fini)(void),
                      void (*rtld_fini)(void), void* stack_end) {
  real_main = main;
  REAL(__libc_start_main);
  return next(counted_main, argc, argv, init, fini, rtld_fini, stack_end);
}

void* malloc(std::size_t size) {
  if (!have_memory()) return early_memory(size);
  return fails(alloc) ? nullptr : count_live(memory.malloc(size));
}
void* calloc(std::size_t count, std::size_t size) {
  if (!have_memory()) return early_memory(count * size);
  return fails(alloc) ? nullptr : count_live(memory.calloc(count, size));
}
void* realloc(void* block, std::size_t size) {
  if (!have_memory() || is_early(block)) _exit(97);
  if (fails(alloc)) return nullptr;
  void* const moved = memory.realloc(block, size);
  if (block == nullptr) count_live(moved);
  return moved;
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  if (!have_memory()) _exit(96);
  return fails(alloc) ? nullptr : count_live(memory.aligned_alloc(alignment, size));
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  *block = aligned_alloc(alignment, size);
  return *block != nullptr ? 0 : ENOMEM;
}
void free(void* block) {
  if (block == nullptr || is_early(block) || !have_memory()) return;
  --live;
  memory.free(block);
}

#define OPEN(name, first_parameter, first)                                          \
  int name(first_parameter const char* path, int flags, ...) {                      \
    std::va_list rest;                                                              \
    va_start(rest, flags);                                                          \
    const mode_t mode = va_arg(rest, mode_t);                                       \
    va_end(rest);                                                                   \
    using Function = int(first_parameter const char*, int, ...);                    \
    static auto* const next = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, #name)); \
    if (fails(open_)) return -1;                                                    \
    const int file = next(first path, flags, mode);                                 \
    trace("open", file, path);                                                      \
    return file;                                                                    \
  }
#define COMMA ,
OPEN(open, , )
OPEN(open64, , )
OPEN(openat, int folder COMMA, folder COMMA)
OPEN(openat64, int folder COMMA, folder COMMA)

std::FILE* fopen(const char* path, const char* mode) {
  REAL(fopen);
  return fails(open_) ? nullptr : next(path, mode);
}
std::FILE* fopen64(const char* path, const char* mode) {
  REAL(fopen64);
  return fails(open_) ? nullptr : next(path, mode);
}

ssize_t read(int file, void* data, std::size_t size) {
  REAL(read);
  return fails(read_) ? -1 : next(file, data, size);
}
std::size_t fread(void* data, std::size_t size, std::size_t count, std::FILE* file) {
  REAL(fread);
  if (fails(read_)) return 0;
  return next(data, size, count, file);
}
ssize_t write(int file, const void* data, std::size_t size) {
  REAL(write);
  if (!fails(write_)) {
    trace("write", file);
    const std::size_t room = room_for(file, size);
    if (room > 0 || size == 0) return next(file, data, room);
    errno = ENOSPC;
    return -1;
  }
  if (error != 0 || size < 2) return -1;
  errno = 0;
  return next(file, data, size / 2);
}
std::size_t fwrite(const void* data, std::size_t size, std::size_t count, std::FILE* file) {
  REAL(fwrite);
  if (file != stdout && file != stderr && fails(write_)) return 0;
  return next(data, size, count, file);
}
int close(int file) {
  REAL(close);
  const bool failing = fails(close_);
  const int result = next(file);
  if (!failing) return result;
  errno = error;
  return -1;
}
int fclose(std::FILE* file) {
  REAL(fclose);
  const bool failing = fails(close_);
  const int result = next(file);
  if (!failing) return result;
  errno = error;
  return EOF;
}

#define SIMPLE(of, result, name, parameters, arguments) \
  result name parameters {                              \
    REAL(name);                                         \
    return fails(of) ? -1 : next arguments;             \
  }

int fsync(int file) {
  REAL(fsync);
  trace("sync", file);
  return fails(sync_) ? -1 : next(file);
}
int rename(const char* from, const char* to) {
  REAL(rename);
  if (fails(rename_) || next(from, to) != 0) return -1;
  trace("rename", from, to);
  return 0;
}
int unlink(const char* path) {
  REAL(unlink);
  trace("remove", path);
  return fails(remove_) ? -1 : next(path);
}
SIMPLE(sync_, int, fdatasync, (int file), (file))
SIMPLE(rename_, int, renameat, (int a, const char* from, int b, const char* to), (a, from, b, to))
SIMPLE(remove_, int, unlinkat, (int folder, const char* path, int flags), (folder, path, flags))
SIMPLE(remove_, int, rmdir, (const char* path), (path))
SIMPLE(remove_, int, remove, (const char* path), (path))
SIMPLE(mkdir_, int, mkdir, (const char* path, mode_t mode), (path, mode))
SIMPLE(stat_, int, stat, (const char* path, struct stat* status), (path, status))
SIMPLE(stat_, int, lstat, (const char* path, struct stat* status), (path, status))
SIMPLE(stat_, int, fstat, (int file, struct stat* status), (file, status))
SIMPLE(stat_, int, fstatat, (int folder, const char* path, struct stat* status, int flags), (folder, path, status, flags))
SIMPLE(stat_, int, fstat64, (int file, struct stat64* status), (file, status))
SIMPLE(stat_, ssize_t, readlink, (const char* path, char* link, std::size_t size), (path, link, size))
SIMPLE(stat_, int, access, (const char* path, int mode), (path, mode))
SIMPLE(lock_, int, flock, (int file, int operation), (file, operation))
SIMPLE(truncate_, off_t, lseek, (int file, off_t to, int from), (file, to, from))
SIMPLE(truncate_, int, ftruncate, (int file, off_t size), (file, size))
SIMPLE(truncate_, int, chmod, (const char* path, mode_t mode), (path, mode))
SIMPLE(truncate_, int, fchmod, (int file, mode_t mode), (file, mode))

int renameat2(int a, const char* from, int b, const char* to, unsigned flags) {
  REAL(renameat2);
  if (no_exchange) {
    errno = EINVAL;
    return -1;
  }
  if (fails(rename_) || next(a, from, b, to, flags) != 0) return -1;
  trace(flags == RENAME_EXCHANGE ? "exchange" : "rename", from, to);
  return 0;
}
char* mkdtemp(char* pattern) {
  REAL(mkdtemp);
  return fails(mkdir_) ? nullptr : next(pattern);
}
DIR* opendir(const char* path) {
  REAL(opendir);
  return fails(folder_) ? nullptr : next(path);
}
DIR* fdopendir(int file) {
  REAL(fdopendir);
  return fails(folder_) ? nullptr : next(file);
}
struct dirent* readdir(DIR* folder) {
  REAL(readdir);
  return fails(folder_) ? nullptr : next(folder);
}
struct dirent64* readdir64(DIR* folder) {
  REAL(readdir64);
  return fails(folder_) ? nullptr : next(folder);
}

}  // extern "C"
