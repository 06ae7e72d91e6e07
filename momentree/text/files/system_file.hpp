#pragma once
// Operating-system file functions that the standard library lacks: descriptors, renaming without replacing, and flushing to
// disk.
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace momentree::io {

/// An open file, closed by the destructor.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() { close(); }

  int number() const { return number_; }
  explicit operator bool() const { return number_ >= 0; }
  /// The error that closing reports: some file systems report only then that data could not be written.
  std::error_code close();

 private:
  int number_ = -1;
};

/// The reason for which the last call of the system failed: errno.
std::error_code last_error();

/// Throws Error: `what`, the reason given by the system, and a hint if there is one.
[[noreturn]] void fail_with_reason(const std::string& what, const std::string& path, std::error_code reason);

enum class Links { follow, refuse };

/// Opens a regular file for reading. Throws Error if there is no such file, if it may not be read, or if it is something else:
/// a folder, a device, a pipe (which would block until a writer comes), a symbolic link if links are refused.
Descriptor open_regular(const std::string& path, Links links = Links::follow);

/// Reads up to `size` bytes; 0 at the end of the file. Throws Error; `path` is for its message.
std::size_t read_some(const Descriptor& file, char* data, std::size_t size, const std::string& path);

/// Reads up to the end of a file. Throws Error; also for a file of more than `largest` bytes.
std::string read_all(const Descriptor& file, std::size_t largest, const std::string& path);

/// Writes all of `text`; `written` counts the bytes that reached the file before an error.
std::error_code write_all(const Descriptor& file, std::string_view text, std::size_t& written);

/// Truncates a file and continues writing there. False if that fails.
bool cut(const Descriptor& file, std::size_t size);

/// Waits until the file's data are on the disk. Devices and pipes, which cannot be flushed, give no error.
std::error_code sync(const Descriptor& file);
/// Like sync(), for the entries of a folder: files made, renamed and removed there.
std::error_code sync_folder(const std::filesystem::path& folder);

/// Renames; `EEXIST` if `to` exists already.
std::error_code move_to_new(const std::filesystem::path& from, const std::filesystem::path& to);
/// Exchanges two files or folders atomically; `std::errc::operation_not_supported` if the file system cannot do that.
std::error_code exchange(const std::filesystem::path& a, const std::filesystem::path& b);

/// The names in a folder, sorted. Throws Error if they cannot be read.
std::vector<std::string> names_in(const std::filesystem::path& folder);
/// Removes a file, or a folder with everything in it, as far as possible. Links are not followed.
void remove_tree(const std::string& path) noexcept;

/// Whether something of that name exists, including a dangling link. Throws Error if that cannot be determined.
bool is_there(const std::filesystem::path& path);

}  // namespace momentree::io
