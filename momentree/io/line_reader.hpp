#pragma once
// The tables and documents of a result folder, as they are read back: regular files alone, errors of reading noticed.
#include <filesystem>
#include <string>

#include <momentree/io/system_file.hpp>

namespace momentree::io {

/// Reads a file line by line, as a stream: it may be large.
class LineReader {
 public:
  /// Throws Error where there is no such regular file, or it can't be read; symbolic links are not followed.
  explicit LineReader(const std::filesystem::path& file);

  /// The next line without its end; false at the end of the file. Throws Error where reading fails.
  bool next(std::string& line);
  /// Of the last line, counted from 1.
  std::size_t number() const { return number_; }
  /// Whether the last line had its end. Else it is the last one of a file that was cut, or is still being written.
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
