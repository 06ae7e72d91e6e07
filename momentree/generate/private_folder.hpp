#pragma once
#include <string>

namespace momentree {

/// A new folder under TMPDIR (or /tmp) that no other user can enter or replace; removed at the end together with the files in
/// `names`.
class PrivateFolder {
 public:
  PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  ~PrivateFolder();

  bool made() const { return !path_.empty(); }
  /// Why it could not be made, and how to correct that.
  const std::string& problem() const { return problem_; }
  /// The absolute path of a file in it.
  std::string file(const std::string& name) const { return path_ + '/' + name; }

  static constexpr const char* names[] = {"kernel.cpp", "kernel.so", "messages"};

 private:
  std::string path_, problem_;
};

/// The innermost of a folder and its parents, all without symbolic links, in which a user other than this one and root can rename
/// or remove this user's files; empty if there is none. Folders like /tmp, in which only the owner can (sticky bit), are safe.
std::string open_to_others(std::string folder);

}  // namespace momentree
