#pragma once
// Text files that are written through a large buffer and notice a full disk, and whole files at once.
#include <string>
#include <string_view>

#include <momentree/io/system_file.hpp>

namespace momentree::io {

/// A file of lines that grows. Append whole lines to `text()`, then call `settle()`: it hands full buffers to the system. Errors
/// are thrown as Error with the file's name and the system's reason; the file then ends with the last whole line that fitted.
class TextFile {
 public:
  /// Makes the file; an error where one of that name exists.
  explicit TextFile(std::string path);

  std::string& text() { return text_; }
  const std::string& path() const { return path_; }
  /// Whether the buffer has grown so large that it should be written.
  bool is_full() const { return text_.size() >= large; }
  void settle() {
    if (is_full()) flush();
  }
  /// Writes the buffer out. After an error the buffer holds what did not fit: another flush tries again.
  void flush();
  /// Flushes, waits for the disk where `to_disk`, and closes.
  void close(bool to_disk = false);

 private:
  static constexpr std::size_t large = 1u << 18;
  std::string path_, text_;
  Descriptor file_;
  std::size_t size_ = 0;  ///< of the file: whole lines
};

/// Writes a whole file, or leaves what was there: the text is written beside it as `PATH.partial-NUMBER`, which takes the file's
/// place once it is on the disk. Links are followed; devices and pipes are written to directly. Throws Error.
void write_text_file(const std::string& path, std::string_view text);

/// The whole text of a regular file; throws Error where it can't be read, is something else, or is larger than 1 GiB.
std::string read_text_file(const std::string& path, Links links = Links::follow);

}  // namespace momentree::io
