#pragma once
// What tells a result folder from any other: a file in it that names what momentree wrote there.
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include <momentree/io/system_file.hpp>

namespace momentree::io {

/// `.momentree` in a result folder: a line for each file that momentree made there, written before the file is. Whoever works on
/// the folder holds a lock on it, which ends with the process, however that ends.
class ResultMarker {
 public:
  static constexpr const char* file_name = ".momentree";

  /// Locks the marker of a folder. Empty where the folder has none, or one that is not momentree's.
  /// Throws Error where another process holds it, or it can't be read or locked.
  static std::optional<ResultMarker> lock(const std::filesystem::path& folder);
  /// The same of a folder that is momentree's or empty: it gets a marker. Empty where the folder is gone, or has files but no
  /// marker of momentree's.
  static std::optional<ResultMarker> make(const std::filesystem::path& folder);

  /// Whether the folder still has this very marker. `folder` may have been renamed since.
  bool is_in(const std::filesystem::path& folder) const noexcept;
  /// Whether `folder / name` is a regular file that momentree made. Throws Error where that can't be found out.
  bool owns(const std::filesystem::path& folder, const std::string& name) const;
  const std::set<std::string>& names() const { return names_; }

  /// Adds names, before files of these names are made. Throws Error where they can't be written.
  void add(std::initializer_list<std::string_view> names);
  /// Waits until it is on the disk. Throws Error.
  void to_disk();
  /// Forgets all names: the files are gone.
  void clear();

 private:
  static std::optional<ResultMarker> open(const std::filesystem::path& folder, int flags);
  bool read();
  void begin();

  std::string path_;  // where it was opened
  Descriptor file_;
  std::set<std::string> names_;
};

}  // namespace momentree::io
