#pragma once
// Reads the tables and documents of a result folder back line by line. Accepts regular files only, and reports read errors.
#include <filesystem>
#include <string>

#include <momentree/text/files/system_file.hpp>

namespace momentree::io {

/// Reads a file line by line as a stream, since it may be large.
class LineReader {
 public:
  /// Throws Error if there is no such regular file, or if it cannot be read; symbolic links are not followed.
  explicit LineReader(const std::filesystem::path& file);

  /// The next line without its line end; false at the end of the file. Throws Error if reading fails.
  bool next(std::string& line);
  /// The number of the last line read, counted from 1.
  std::size_t number() const { return number_; }
  /// Whether the last line read was terminated. If not, it is the last line of a file that was truncated or is still being
  /// written.
  bool is_whole() const { return whole_; }

 private:
  bool refill();

  std::string path_;
  Descriptor file_;
  std::string buffer_;
  std::size_t at_ = 0, number_ = 0;
  bool whole_ = false;
};

}  // namespace momentree::io
