#pragma once
// Input files: regular files of bounded size, and the rules for which files another file may name.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace momentree::io {

/// Why a file cannot be read.
struct Unreadable {
  std::string what, hint;
  bool missing = false;  ///< the file does not exist
};

/// Why there is no readable regular file at `path`, which should be a `what` ("model"); nothing if there is one. Symbolic links
/// are followed, and nothing is opened.
std::optional<Unreadable> why_unreadable(const std::string& path, const char* what);

/// Reads the whole text of a regular file of at most `largest` bytes, which should be a `what`. Returns false if that fails;
/// `why` then gives the reason. Devices, pipes and sockets are rejected before they are opened.
bool read_whole_file(const std::string& path, const char* what, std::uintmax_t largest, std::string& text, Unreadable& why);

/// The folders whose files a file may name: its own folder and, if the file is a symbolic link, the folder of the link's
/// target; subfolders are included.
class Enclosure {
 public:
  /// Encloses nothing: no file is accessed.
  Enclosure() = default;
  /// The enclosure of the file at `path`.
  explicit Enclosure(const std::string& path);
  /// True if `path`, with its symbolic links and `..` resolved, is in one of the folders, or if the file does not exist.
  bool holds(const std::filesystem::path& path) const;

 private:
  std::vector<std::filesystem::path> folders_;  // with symbolic links resolved
};

}  // namespace momentree::io
