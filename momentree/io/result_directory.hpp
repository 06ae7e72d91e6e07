#pragma once
// Where a run writes: beside its destination while it runs, in its place when it is whole.
#include <filesystem>
#include <string>

namespace momentree::io {

/// Files are written in `DESTINATION.partial`. `publish` moves that to `DESTINATION`; a run that fails leaves it as it is.
class ResultDirectory {
 public:
  /// Makes an empty `DESTINATION.partial` (one of an earlier run is replaced) and the folders above it.
  /// Throws Error where it can't be made or written, and where the destination is something that a run would not replace:
  /// a file, or a folder that has files in it but no result of momentree.
  explicit ResultDirectory(const std::string& destination);

  const std::filesystem::path& destination() const { return destination_; }
  const std::filesystem::path& working() const { return working_; }
  /// A file of the result, while the run writes.
  std::string file(const char* name) const { return (working_ / name).string(); }

  /// Puts the result in its place. An earlier result there is removed; files in it that no run writes (pictures, notes) are kept.
  void publish();

 private:
  std::filesystem::path destination_, working_;
};

}  // namespace momentree::io
