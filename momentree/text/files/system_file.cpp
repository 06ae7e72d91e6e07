#include <momentree/text/files/system_file.hpp>

#include <dirent.h>
#include <fcntl.h>
#include <ftw.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <memory>

#include <momentree/base/error.hpp>

namespace momentree::io {

namespace {

bool is_one_of(std::error_code error, std::initializer_list<std::errc> kinds) {
  for (const std::errc kind : kinds)
    if (error == kind) return true;
  return false;
}

// Some file systems do not support flushing.
std::error_code sync_number(int number) {
  while (::fsync(number) != 0) {
    if (errno == EINTR) continue;
    const std::error_code error = last_error();
    return is_one_of(error, {std::errc::invalid_argument, std::errc::not_supported, std::errc::operation_not_supported,
                             std::errc::function_not_supported})
               ? std::error_code()
               : error;
  }
  return {};
}

}  // namespace

std::error_code last_error() { return {errno, std::generic_category()}; }

std::error_code Descriptor::close() {
  const int number = std::exchange(number_, -1);
  if (number < 0 || ::close(number) == 0 || errno == EINTR) return {};  // after EINTR Linux has closed it
  return last_error();
}

void fail_with_reason(const std::string& what, const std::string& path, std::error_code reason) {
  const bool full = reason == std::errc::no_space_on_device || reason.value() == EDQUOT;
  const bool limited = reason == std::errc::file_too_large;
  throw_error({what + ": " + reason.message(), path,
               full ? "free some space there, or write elsewhere"
               : limited
                   ? "the limit on file sizes is too low: raise it (`ulimit -f unlimited`), or use a longer interval between rows"
                   : ""});
}

Descriptor open_regular(const std::string& path, Links links) {
  const int flags = O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK | (links == Links::refuse ? O_NOFOLLOW : 0);
  Descriptor file(::open(path.c_str(), flags));
  if (!file) {
    const std::error_code error = last_error();
    if (error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory)
      throw_error({"there is no such file", path, ""});
    if (links == Links::refuse && error == std::errc::too_many_symbolic_link_levels)
      throw_error({"this is a symbolic link, which cannot be used here", path, "replace it with the file itself"});
    if (error == std::errc::no_such_device_or_address)  // a socket
      throw_error({"this is not a regular file", path, ""});
    fail_with_reason("cannot read this file", path, error);
  }
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) fail_with_reason("cannot read this file", path, last_error());
  if (!S_ISREG(status.st_mode))
    throw_error({S_ISDIR(status.st_mode) ? "this is a folder, not a file" : "this is not a regular file", path, ""});
  return file;
}

std::size_t read_some(const Descriptor& file, char* data, std::size_t size, const std::string& path) {
  for (;;) {
    const ssize_t count = ::read(file.number(), data, size);
    if (count >= 0) return static_cast<std::size_t>(count);
    if (errno != EINTR) fail_with_reason("cannot read this file", path, last_error());
  }
}

std::string read_all(const Descriptor& file, std::size_t largest, const std::string& path) {
  constexpr std::size_t least = 1u << 16;
  struct stat status {};
  std::size_t expected = 0;
  if (::fstat(file.number(), &status) == 0 && status.st_size > 0) expected = static_cast<std::size_t>(status.st_size);
  std::string text;
  for (std::size_t size = 0;;) {  // the file may grow or shrink meanwhile, and files in /proc have no size
    if (size > largest || expected > largest)
      throw_error({"this file is larger than " + std::to_string(largest >> 20) + " MiB", path, ""});
    if (size == text.size()) text.resize(std::max({2 * size, expected + 1, std::size_t{least}}));
    const std::size_t count = read_some(file, text.data() + size, text.size() - size, path);
    size += count;
    if (count > 0) continue;
    text.resize(size);
    return text;
  }
}

std::error_code write_all(const Descriptor& file, std::string_view text, std::size_t& written) {
  for (written = 0; written < text.size();) {
    const ssize_t count = ::write(file.number(), text.data() + written, text.size() - written);
    if (count > 0)
      written += static_cast<std::size_t>(count);
    else if (count == 0)
      return std::make_error_code(std::errc::io_error);  // otherwise the call would be repeated forever
    else if (errno != EINTR)
      return last_error();
  }
  return {};
}

bool cut(const Descriptor& file, std::size_t size) {
  const auto end = static_cast<off_t>(size);
  return ::ftruncate(file.number(), end) == 0 && ::lseek(file.number(), end, SEEK_SET) == end;
}

std::error_code sync(const Descriptor& file) { return file ? sync_number(file.number()) : std::error_code(); }

std::error_code sync_folder(const std::filesystem::path& folder) {
  const Descriptor opened(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return opened ? sync_number(opened.number()) : last_error();
}

std::error_code move_to_new(const std::filesystem::path& from, const std::filesystem::path& to) {
#ifdef RENAME_NOREPLACE
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return {};
  const std::error_code error = last_error();
  if (!is_one_of(error, {std::errc::invalid_argument, std::errc::function_not_supported, std::errc::operation_not_supported}))
    return error;
#endif
  struct stat status {};
  if (::lstat(to.c_str(), &status) == 0) return std::make_error_code(std::errc::file_exists);
  if (errno != ENOENT || ::rename(from.c_str(), to.c_str()) != 0) return last_error();
  return {};
}

std::error_code exchange(const std::filesystem::path& a, const std::filesystem::path& b) {
#ifdef RENAME_EXCHANGE
  if (::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0) return {};
  const std::error_code error = last_error();
  if (!is_one_of(error, {std::errc::invalid_argument, std::errc::function_not_supported, std::errc::operation_not_supported}))
    return error;
#endif
  return std::make_error_code(std::errc::operation_not_supported);
}

std::vector<std::string> names_in(const std::filesystem::path& folder) {
  const auto require = [&folder](bool fine) {
    if (!fine) fail_with_reason("cannot read this folder", folder.string(), last_error());
  };
  const std::unique_ptr<DIR, int (*)(DIR*)> opened(::opendir(folder.c_str()), ::closedir);
  require(opened != nullptr);
  std::vector<std::string> names;
  for (;;) {
    errno = 0;
    const dirent* const entry = ::readdir(opened.get());
    require(entry != nullptr || errno == 0);
    if (entry == nullptr) break;
    if (const std::string_view name = entry->d_name; name != "." && name != "..") names.emplace_back(name);
  }
  std::ranges::sort(names);
  return names;
}

void remove_tree(const std::string& path) noexcept {
  const auto remove = [](const char* name, const struct stat*, int, FTW*) { return ::remove(name), 0; };
  constexpr int descriptors = 16;
  for (int tries = 0; tries < 2; ++tries)  // the traversal allocates memory: a second attempt may succeed
    if (::nftw(path.c_str(), remove, descriptors, FTW_DEPTH | FTW_PHYS) == 0) return;
}

bool is_there(const std::filesystem::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) == 0) return true;
  if (errno == ENOENT || errno == ENOTDIR) return false;
  fail_with_reason("cannot access this", path.string(), last_error());
}

}  // namespace momentree::io
