#pragma once
// A text file that is written through one large buffer, and that notices a full disk.
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace momentree::io {

/// Append to `text()`, then call `settle()`: it hands full buffers to the system. Errors of opening, writing and closing are
/// thrown as Error with the file's name and the system's reason.
class TextFile {
 public:
  explicit TextFile(std::string path);

  std::string& text() { return text_; }
  const std::string& path() const { return path_; }
  /// Writes the buffer out where it has grown large.
  void settle() {
    if (text_.size() >= large) flush();
  }
  /// Writes the buffer out.
  void flush();
  /// Flushes and closes. A file that is destroyed without it may be incomplete: an error would have nowhere to go.
  void close();

 private:
  static constexpr std::size_t large = 1u << 18;
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_, text_;
  std::unique_ptr<std::FILE, Closer> file_;
};

/// Writes a whole file at once; throws as TextFile does.
void write_text_file(const std::string& path, std::string_view text);

/// The whole text of a regular file; throws Error where it can't be read, is a directory or a device, or larger than 1 GiB.
std::string read_text_file(const std::string& path);

}  // namespace momentree::io
