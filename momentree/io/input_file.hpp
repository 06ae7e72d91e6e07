#pragma once
// Files that are read: regular ones of a bounded size, and which of them another file may name.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace momentree::io {

/// Why a file can't be read.
struct Unreadable {
  std::string what, hint;
  bool missing = false;  ///< nothing stands there
};

/// Why there is no regular file to be read at `path`, which should be a `what` ("model"); nothing where there is one. Symbolic
/// links are followed, and nothing is opened.
std::optional<Unreadable> why_unreadable(const std::string& path, const char* what);

/// The whole text of a regular file of at most `largest` bytes, which should be a `what`. False if there is no such file; `why`
/// says more. Devices, pipes and sockets are refused before they are opened.
bool read_whole_file(const std::string& path, const char* what, std::uintmax_t largest, std::string& text, Unreadable& why);

/// The folders whose files a file may name: its own, and, where it is itself a symbolic link, that of the file that it leads to;
/// with all that is below them.
class Enclosure {
 public:
  /// Encloses nothing: no file is looked for.
  Enclosure() = default;
  /// Around the file at `path`.
  explicit Enclosure(const std::string& path);
  /// True where `path`, its symbolic links and `..` followed, is in one of the folders, or where nothing stands there.
  bool holds(const std::filesystem::path& path) const;

 private:
  std::vector<std::filesystem::path> folders_;  // without symbolic links
};

}  // namespace momentree::io
