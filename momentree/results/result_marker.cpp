#include <momentree/results/result_marker.hpp>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include <momentree/base/error.hpp>

namespace momentree::io {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view first_line =
    "A result of momentree. The next run into this folder replaces these files, and no others:\n";

bool is_empty_or_gone(const fs::path& folder) { return !is_there(folder) || names_in(folder).empty(); }

}  // namespace

std::optional<ResultMarker> ResultMarker::lock(const fs::path& folder) { return open(folder, 0); }

std::optional<ResultMarker> ResultMarker::make(const fs::path& folder) {
  return open(folder, is_there(folder / file_name) || !is_empty_or_gone(folder) ? 0 : O_CREAT);
}

std::optional<ResultMarker> ResultMarker::open(const fs::path& folder, int flags) {
  ResultMarker marker;
  marker.path_ = (folder / file_name).string();
  for (int tries = 0;; ++tries) {
    if (tries == 1000) throw_error({"cannot lock this file", marker.path_, ""});
    marker.file_ = Descriptor(::open(marker.path_.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC | flags, 0666));
    if (!marker.file_) {
      if (errno == ENOENT || errno == ENOTDIR || errno == ELOOP || errno == EISDIR || errno == ENXIO) return std::nullopt;
      fail_with_reason("cannot open this file, which marks results of momentree", marker.path_, last_error());
    }
    struct stat status {};
    if (::fstat(marker.file_.number(), &status) != 0) fail_with_reason("cannot access this file", marker.path_, last_error());
    if (!S_ISREG(status.st_mode)) return std::nullopt;
    if (::flock(marker.file_.number(), LOCK_EX | LOCK_NB) != 0) {
      if (errno == EINTR) continue;
      if (errno == EWOULDBLOCK)
        throw_error({"another run of momentree is writing into this folder", folder.string(),
                     "wait until it has ended, or name another folder with --out"});
      fail_with_reason("cannot lock this file against other runs that write into the folder", marker.path_, last_error());
    }
    if (marker.is_in(folder)) break;  // otherwise the process that held the lock has removed or moved it meanwhile
  }
  if (!marker.read()) return std::nullopt;
  return marker;
}

// Allocates no memory, since it is called while a result is being moved.
bool ResultMarker::is_in(const fs::path& folder) const noexcept {
  char path[4096];
  const int length = std::snprintf(path, sizeof path, "%s/%s", folder.c_str(), file_name);
  struct stat here {
  }, there{};
  return length < static_cast<int>(sizeof path) && ::fstat(file_.number(), &here) == 0 && ::lstat(path, &there) == 0 &&
         here.st_dev == there.st_dev && here.st_ino == there.st_ino;
}

bool ResultMarker::owns(const fs::path& folder, const std::string& name) const {
  if (!names_.contains(name)) return false;
  struct stat status {};
  const fs::path path = folder / name;
  if (::lstat(path.c_str(), &status) == 0) return S_ISREG(status.st_mode);
  if (errno == ENOENT) return false;
  fail_with_reason("cannot access this file", path.string(), last_error());
}

// False if it is another program's file of that name. A truncated one was made by a run that was killed before it made other
// files.
bool ResultMarker::read() {
  constexpr std::size_t largest = 1u << 16;
  std::string text(largest, '\0');
  std::size_t size = 0;
  while (const std::size_t count = read_some(file_, text.data() + size, largest - size, path_)) size += count;
  text.resize(size);
  if (first_line.starts_with(text)) return begin(), true;
  if (!text.starts_with(first_line)) return false;
  for (std::size_t at = first_line.size(), end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
    if (const std::string name = text.substr(at, end - at); !name.empty() && name.find('/') == std::string::npos)
      names_.insert(name);
  return true;
}

void ResultMarker::begin() {
  std::size_t written = 0;
  const std::error_code error = ::lseek(file_.number(), 0, SEEK_SET) == 0 ? write_all(file_, first_line, written) : last_error();
  if (!error) return;
  ::unlink(path_.c_str());
  fail_with_reason("cannot write this file", path_, error);
}

void ResultMarker::add(std::initializer_list<std::string_view> names) {
  std::string text;
  for (const std::string_view name : names)
    if (!names_.contains(std::string(name))) text += std::string(name) + '\n';
  if (text.empty()) return;
  const off_t end = ::lseek(file_.number(), 0, SEEK_END);
  std::size_t written = 0;
  if (const std::error_code error = end < 0 ? last_error() : write_all(file_, text, written)) {
    if (written > 0) cut(file_, static_cast<std::size_t>(end));
    fail_with_reason("cannot write this file", path_, error);
  }
  for (const std::string_view name : names) names_.emplace(name);
}

void ResultMarker::to_disk() {
  if (const std::error_code error = sync(file_)) fail_with_reason("cannot finish writing", path_, error);
}

void ResultMarker::clear() {
  if (!cut(file_, first_line.size())) fail_with_reason("cannot write this file", path_, last_error());
  names_.clear();
}

}  // namespace momentree::io
