#pragma once
// Where a run writes: beside its destination while it runs, in its place when it is whole.
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/io/result_marker.hpp>
#include <momentree/io/system_file.hpp>

namespace momentree::io {

/// Files are written in `DESTINATION.partial`; `publish` puts that folder into the place of `DESTINATION`. At every instant, also
/// where the process is killed, the earlier result or the new one is there, whole. Both folders are locked until the end. Only
/// files that the folders' markers name, and that momentree therefore made, are ever removed.
class ResultDirectory {
 public:
  /// Makes `DESTINATION.partial`, and the folders above it; the files of an earlier run there are removed. `files`: names that
  /// will be written. `lasting`: what is published is on the disk, and would survive a power failure.
  /// Throws Error, and leaves everything as it was, where the folder can't be made, where another run is at work on it, and
  /// where something would have to be replaced that momentree did not write.
  explicit ResultDirectory(const std::string& destination, std::vector<std::string> files = {}, bool lasting = true);
  /// Removes what it made, unless `keep` was called.
  ~ResultDirectory();
  ResultDirectory(const ResultDirectory&) = delete;
  ResultDirectory& operator=(const ResultDirectory&) = delete;

  const std::filesystem::path& destination() const { return destination_; }
  const std::filesystem::path& working() const { return working_; }

  /// The path of a file that is about to be made in the folder.
  std::string file(const char* name);
  /// Writes a file that is whole or absent; one of momentree's with that name is replaced. `from_reserve`: into the room that
  /// `reserve` took.
  void write(const char* name, std::string_view text, bool from_reserve = false);
  /// Removes a file that was written; no error where it is not there.
  void remove(const char* name) noexcept;
  /// Takes up room on the disk, so that a file of up to `size` bytes can be written even if the disk is full by then.
  void reserve(std::size_t size);

  /// From now on what is there stays if the run ends before it is published.
  void keep() { kept_ = true; }

  /// Puts the folder into the place of the destination, whose files of momentree's own are removed; all others stay there.
  /// Returns warnings: what of the earlier result could not be moved or removed. Throws Error where the destination is unchanged.
  std::vector<std::string> publish();

 private:
  void name_folders(const std::string& destination);
  void begin();
  void lock_working();
  void bring_back_former();
  void check_destination();
  void check_names() const;
  void replace_destination(std::vector<std::string>& warnings);
  void discard() noexcept;

  std::filesystem::path destination_, working_;
  std::vector<std::string> files_;
  bool lasting_;
  std::optional<ResultMarker> marker_;              ///< of the working folder, with which it moves
  std::optional<ResultMarker> destination_marker_;  ///< of the earlier result
  std::filesystem::path topmost_made_;              ///< of the folders above, the first that did not exist
  bool made_ = false, cleared_ = false, kept_ = false;
  Descriptor reserve_;
};

}  // namespace momentree::io
