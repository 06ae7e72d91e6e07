#pragma once
// A C++ compiler as a child process, and what it made as part of this one. POSIX.
#include <memory>
#include <string>
#include <vector>

namespace momentree {

/// The compiler and its arguments: of `asked`, or else of MOMENTREE_CXX, CXX, or c++, g++, clang++, whichever is there first.
/// Text that is the path of a program names it, spaces and all; other text is split at its spaces, and nothing in it is a quote
/// or a shell's. The program comes as a path; empty where there is none. What is asked for and is not there is no reason to take
/// another.
std::vector<std::string> find_compiler(const std::string& asked);

/// A loaded shared object; closed with its last copy.
class Library {
 public:
  Library() = default;
  explicit operator bool() const { return handle_ != nullptr; }
  /// The address of a symbol of C, or null.
  void* symbol(const char* name) const;

 private:
  friend Library compile_library(const std::vector<std::string>&, const std::string&, std::string&);
  std::shared_ptr<void> handle_;
};

/// Compiles the text of a C++20 file for this CPU, in a PrivateFolder, and loads it; the compiler is not empty. Where that fails
/// the result is empty and `why` says so. Leaves nothing behind on the disk.
Library compile_library(const std::vector<std::string>& compiler, const std::string& source, std::string& why);

}  // namespace momentree
