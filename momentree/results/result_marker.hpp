#pragma once
// The marker that identifies a result folder: a file in it that lists what momentree wrote there.
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include <momentree/text/files/system_file.hpp>

namespace momentree::io {

/// `.momentree` in a result folder: one line per file that momentree made there, written before that file is. Any process that
/// works on the folder holds a lock on the marker, which ends with the process, even if it is killed.
class ResultMarker {
 public:
  static constexpr const char* file_name = ".momentree";

  /// Locks the marker of a folder. Empty if the folder has none, or one that is not momentree's. Throws Error if another
  /// process holds it, or if it cannot be read or locked.
  static std::optional<ResultMarker> lock(const std::filesystem::path& folder);
  /// Like lock(), for a folder that is momentree's or empty; an empty one gets a marker. Empty if the folder does not exist, or
  /// has files but no marker of momentree's.
  static std::optional<ResultMarker> make(const std::filesystem::path& folder);

  /// Whether the folder still contains this very marker. `folder` may have been renamed since.
  bool is_in(const std::filesystem::path& folder) const noexcept;
  /// Whether `folder / name` is a regular file that momentree made. Throws Error if that cannot be determined.
  bool owns(const std::filesystem::path& folder, const std::string& name) const;
  const std::set<std::string>& names() const { return names_; }

  /// Adds names, before files of these names are made. Throws Error if they cannot be written.
  void add(std::initializer_list<std::string_view> names);
  /// Flushes the marker to disk. Throws Error.
  void to_disk();
  /// Removes all names, once the files are gone.
  void clear();

 private:
  static std::optional<ResultMarker> open(const std::filesystem::path& folder, int flags);
  bool read();
  void begin();

  std::string path_;  // where the marker was opened
  Descriptor file_;
  std::set<std::string> names_;
};

}  // namespace momentree::io
