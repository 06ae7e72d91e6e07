#pragma once
// Text files written through a large buffer, with detection of a full disk, and functions for whole files.
#include <string>
#include <string_view>

#include <momentree/text/files/checksum.hpp>
#include <momentree/text/files/system_file.hpp>

namespace momentree::io {

/// A file of lines that grows. Append whole lines to `text()`, then call `settle()`, which writes full buffers out. Errors are
/// thrown as Error with the file's name and the system's reason; the file then ends with the last whole line that fitted.
class TextFile {
 public:
  /// Makes the file; throws Error if one of that name exists.
  explicit TextFile(std::string path);

  /// How far a file had been written.
  struct Mark {
    std::uint64_t size = 0, checksum = 0;  ///< bytes, and the Checksum of them
  };
  /// Opens a file that had been written up to there and cuts off what follows; the bytes before are taken as they are (see
  /// require_unchanged). Throws Error.
  TextFile(std::string path, const Mark& end);

  std::string& text() { return text_; }
  const std::string& path() const { return path_; }
  /// Whether the buffer has grown so large that it should be written.
  bool is_full() const { return text_.size() >= large; }
  void settle() {
    if (is_full()) flush();
  }
  /// Writes the buffer out. After an error the buffer holds what did not fit, so that flush() can be called again.
  void flush() { flush(text_.size()); }
  /// The same for the first `count` bytes of the buffer alone: whole lines.
  void flush(std::size_t count);
  /// Keeps a checksum of what is written; to be called before anything is.
  void keep_checksum() { keeps_checksum_ = true; }
  /// What has been written so far, once it is on the disk; needs keep_checksum(). Throws Error.
  Mark mark();
  /// Flushes, waits until the data are on the disk if `to_disk`, and closes.
  void close(bool to_disk = false);

 private:
  static constexpr std::size_t large = 1u << 18;
  std::string path_, text_;
  Descriptor file_;
  void written(std::size_t count);
  std::size_t size_ = 0;  ///< of the file's whole lines (bytes)
  bool keeps_checksum_ = false;
  Checksum checksum_;  ///< of them
};

/// Throws Error unless the file still begins with the bytes of that mark.
void require_unchanged(const std::string& path, const TextFile::Mark& mark);

/// Writes a whole file, or leaves the old one unchanged: the text is written to `PATH.partial-NUMBER`, which replaces the file
/// once it is on the disk. Links are followed; devices and pipes are written to directly. Throws Error.
void write_text_file(const std::string& path, std::string_view text);

/// The whole text of a regular file; throws Error if it cannot be read, is something else, or is larger than 1 GiB.
std::string read_text_file(const std::string& path, Links links = Links::follow);

}  // namespace momentree::io
