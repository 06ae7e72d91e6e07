#include <momentree/text/files/text_file.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/base/error.hpp>

namespace momentree::io {

namespace fs = std::filesystem;

namespace {

Descriptor make_new(const std::string& path, unsigned mode = 0666) {
  return Descriptor(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode));
}

// The end of a chain of symbolic links; the file there may not exist yet.
std::string end_of_links(const std::string& path) {
  fs::path end = path;
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(end, error)); ++links) {
    const fs::path next = fs::read_symlink(end, error);
    if (error || links == 40)
      fail_with_reason("cannot follow this link", path,
                       error ? error : std::make_error_code(std::errc::too_many_symbolic_link_levels));
    end = end.parent_path() / next;
  }
  return end.string();
}

// For a device or a pipe, which cannot be replaced by another file.
void write_directly(const std::string& path, std::string_view text) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY));
  if (!file) fail_with_reason("cannot write this file", path, last_error());
  std::size_t written = 0;
  std::error_code error = write_all(file, text, written);
  if (!error) error = file.close();
  if (error) fail_with_reason("cannot write this file", path, error);
}

/// A temporary file that will replace another; removed unless it does.
class Replacement {
 public:
  Replacement(const std::string& target, unsigned mode) {
    const fs::path place(target);
    // A file name may have at most 255 bytes.
    const std::string stem = (place.parent_path() / place.filename().string().substr(0, 200)).string() + ".partial-";
    for (int i = 0; !file_ && i < 100; ++i) {
      path_ = stem + std::to_string(::getpid()) + (i == 0 ? "" : "-" + std::to_string(i));
      file_ = make_new(path_, mode);
      if (!file_ && errno != EEXIST) break;
    }
    if (!file_) fail_with_reason("cannot write this file", target, last_error());
  }
  Replacement(const Replacement&) = delete;
  Replacement& operator=(const Replacement&) = delete;
  ~Replacement() {
    if (!path_.empty()) ::unlink(path_.c_str());
  }
  const Descriptor& file() const { return file_; }

  std::error_code take_place_of(const std::string& target) {
    const fs::path folder = fs::path(target).parent_path();
    if (const std::error_code error = sync(file_)) return error;
    if (const std::error_code error = file_.close()) return error;
    if (::rename(path_.c_str(), target.c_str()) != 0) return last_error();
    path_.clear();
    sync_folder(folder);  // the file is complete and in place: there is nothing left to undo
    return {};
  }

 private:
  std::string path_;
  Descriptor file_;
};

}  // namespace

TextFile::TextFile(std::string path) : path_(std::move(path)), file_(make_new(path_)) {
  if (!file_) fail_with_reason("cannot make this file", path_, last_error());
}

TextFile::TextFile(std::string path, const Mark& end)
    : path_(std::move(path)),
      file_(::open(path_.c_str(), O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC)),
      size_(static_cast<std::size_t>(end.size)),
      keeps_checksum_(true),
      checksum_(end.checksum) {
  if (!file_ || !cut(file_, size_)) fail_with_reason("cannot continue this file", path_, last_error());
}

void TextFile::written(std::size_t count) {
  size_ += count;
  if (keeps_checksum_) checksum_.add(std::string_view(text_).substr(0, count));
  text_.erase(0, count);
}

void TextFile::flush(std::size_t count) {
  const std::string_view lines = std::string_view(text_).substr(0, count);
  std::size_t done = 0;
  const std::error_code error = write_all(file_, lines, done);
  if (!error) return written(lines.size());
  const std::size_t newline = lines.substr(0, done).rfind('\n');
  const std::size_t whole = newline == std::string::npos ? 0 : newline + 1;
  written(whole);
  if (done > whole) cut(file_, size_);  // if that fails, too, readers ignore a line without an end
  fail_with_reason("cannot write this file", path_, error);
}

TextFile::Mark TextFile::mark() {
  MT_REQUIRE(keeps_checksum_, "keep_checksum() was called");
  if (const std::error_code error = sync(file_)) fail_with_reason("cannot write this file", path_, error);
  return {size_, checksum_.value()};
}

void require_unchanged(const std::string& path, const TextFile::Mark& mark) {
  const Descriptor file = open_regular(path, Links::refuse);
  std::string piece(1u << 18, '\0');
  Checksum checksum;
  for (std::uint64_t left = mark.size; left > 0;) {
    const std::size_t count =
        read_some(file, piece.data(), static_cast<std::size_t>(std::min<std::uint64_t>(left, piece.size())), path);
    if (count == 0)
      throw_error({"this file is shorter than it was at the checkpoint", path, "run without --resume to start again"});
    checksum.add(std::string_view(piece).substr(0, count));
    left -= count;
  }
  if (checksum.value() != mark.checksum)
    throw_error({"this file was changed after the checkpoint", path, "run without --resume to start again"});
}

void TextFile::close(bool to_disk) {
  flush();
  std::error_code error = to_disk ? sync(file_) : std::error_code();
  if (const std::error_code at_end = file_.close(); !error) error = at_end;
  if (error) fail_with_reason("cannot finish writing", path_, error);
}

void write_text_file(const std::string& path, std::string_view text) {
  const std::string target = end_of_links(path);
  struct stat status {};
  const bool exists = ::stat(target.c_str(), &status) == 0;
  if (!exists && errno != ENOENT) fail_with_reason("cannot write this file", path, last_error());
  if (exists && S_ISDIR(status.st_mode))
    throw_error({"this is a folder, not a file that can be written", path, "name a file in it"});
  if (exists && !S_ISREG(status.st_mode)) return write_directly(path, text);
  if (exists && ::access(target.c_str(), W_OK) != 0) fail_with_reason("cannot write this file", path, last_error());

  Replacement fresh(target, exists ? status.st_mode & 0777 : 0666);
  if (exists && ::fchmod(fresh.file().number(), status.st_mode & 0777) != 0)
    fail_with_reason("cannot write this file", path, last_error());
  std::size_t written = 0;
  std::error_code error = write_all(fresh.file(), text, written);
  if (!error) error = fresh.take_place_of(target);
  if (error) fail_with_reason("cannot write this file", path, error);
}

std::string read_text_file(const std::string& path, Links links) { return read_all(open_regular(path, links), 1u << 30, path); }

}  // namespace momentree::io
