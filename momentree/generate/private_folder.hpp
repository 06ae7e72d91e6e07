#pragma once
#include <string>

namespace momentree {

/// A new folder under TMPDIR (or /tmp) that no other user can enter or exchange for another; gone at the end with the files that
/// were asked for.
class PrivateFolder {
 public:
  PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  ~PrivateFolder();

  bool made() const { return !path_.empty(); }
  /// Why it was not made, and how to mend that.
  const std::string& problem() const { return problem_; }
  /// The absolute path of a file in it.
  std::string file(const std::string& name) const { return path_ + '/' + name; }

  static constexpr const char* names[] = {"kernel.cpp", "kernel.so", "messages"};

 private:
  std::string path_, problem_;
};

/// The innermost of a folder and those above it, all without symbolic links, in which another user than this one and root can
/// rename or remove what belongs to this one; empty if there is no such folder. Folders like /tmp, where only the owner can (the
/// sticky bit), are fine.
std::string open_to_others(std::string folder);

}  // namespace momentree
