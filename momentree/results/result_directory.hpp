#pragma once
// The folder that a run writes into: a sibling of its destination while the run is in progress, the destination itself once it
// is complete.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <momentree/results/result_marker.hpp>
#include <momentree/text/files/system_file.hpp>

namespace momentree::io {

/// Files with which unfinished results can be continued: of a sweep, and of a run.
inline constexpr const char* journal_file = "sweep.journal";
inline constexpr const char* checkpoint_file = "checkpoint";

/// Files are written in `DESTINATION.partial`; `publish` moves that folder to `DESTINATION`. At every instant, even if the
/// process is killed, a complete result exists: the earlier one or the new one. Both folders are locked until the end. Only
/// files that the folders' markers name, and that momentree therefore wrote, are ever removed.
class ResultDirectory {
 public:
  /// What happens to the files of an earlier run that did not end.
  enum class Earlier { removed, kept };

  /// Makes `DESTINATION.partial` and its parent folders, and removes the files of an earlier run from it, unless they are kept
  /// so that the run can be continued. The journal of a sweep is not removed: that is an error. `files`: names that will be
  /// written. `lasting`: the published result is flushed to disk, so that it survives a power failure. Throws Error, and leaves
  /// everything as it was, if the folder cannot be made, if another run is using it, or if it would have to replace something
  /// that momentree did not write.
  explicit ResultDirectory(const std::string& destination, std::vector<std::string> files = {}, bool lasting = true,
                           Earlier earlier = Earlier::removed);
  /// Takes up `DESTINATION.partial` of a run that ended before its result was complete, if the folder has the file `needed`;
  /// otherwise null. Nothing in it is changed before `take_up`. Throws Error as the constructor does.
  static std::unique_ptr<ResultDirectory> reopen(const std::string& destination, std::vector<std::string> files,
                                                 const char* needed);
  /// Removes what this object made, unless `keep` was called.
  ~ResultDirectory();
  ResultDirectory(const ResultDirectory&) = delete;
  ResultDirectory& operator=(const ResultDirectory&) = delete;

  const std::filesystem::path& destination() const { return destination_; }
  const std::filesystem::path& working() const { return working_; }

  /// After reopen(): removes the documents with which the former run ended.
  void take_up();
  /// Whether momentree wrote a file of that name in the working folder: in an earlier run, or in this one.
  bool has(const char* name) const;
  /// Removes what an earlier run left and was kept.
  void clear();
  /// Removes the working folder and what momentree wrote in it; nothing else may be called afterwards.
  void remove_all() noexcept;

  /// The path of a file that is about to be written in the folder.
  std::string file(const char* name);
  /// Writes a file atomically; a file of that name that momentree wrote is replaced. `from_reserve`: uses the space that
  /// `reserve` allocated.
  void write(const char* name, std::string_view text, bool from_reserve = false);
  /// Removes a file that was written; a missing file is not an error.
  void remove(const char* name) noexcept;
  /// Waits until the names of all files are on the disk, as well as what write() wrote. Throws Error.
  void to_disk();
  /// Allocates disk space, so that a file of up to `size` bytes can be written even if the disk is full by then.
  void reserve(std::size_t size);

  /// From now on, the files are kept even if the run ends before it is published.
  void keep() { kept_ = true; }

  /// Moves the folder to the destination. Files there that momentree wrote are removed; all others stay. Returns warnings:
  /// files of the earlier result that could not be moved or removed. Throws Error if the destination is unchanged.
  /// `temporary`: files that are removed once the result is at the destination.
  std::vector<std::string> publish(const std::vector<const char*>& temporary = {});

 private:
  ResultDirectory(std::vector<std::string> files, bool lasting)
      : files_(std::move(files)), lasting_(lasting), earlier_(Earlier::kept) {}
  void remove_former();
  void name_folders(const std::string& destination);
  void begin();
  void lock_working();
  void bring_back_former();
  void check_destination();
  void check_names() const;
  void remove_published(const std::vector<const char*>& names, std::vector<std::string>& warnings) noexcept;
  void replace_destination(const std::vector<const char*>& temporary, std::vector<std::string>& warnings);
  void discard() noexcept;

  std::filesystem::path destination_, working_;
  std::vector<std::string> files_;
  bool lasting_;
  Earlier earlier_;
  std::optional<ResultMarker> marker_;              ///< of the working folder, and moves with it
  std::optional<ResultMarker> destination_marker_;  ///< of the earlier result
  std::filesystem::path topmost_made_;              ///< the topmost parent folder that did not exist
  bool made_ = false, cleared_ = false, kept_ = false;
  Descriptor reserve_;
};

}  // namespace momentree::io
