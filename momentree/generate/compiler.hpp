#pragma once
// A C++ compiler as a child process, and the libraries that it makes, loaded into this process. POSIX.
#include <memory>
#include <string>
#include <vector>

namespace momentree {

/// The compiler and its arguments: from `asked`, or else MOMENTREE_CXX, CXX, or the first existing of c++, g++, clang++. Text
/// that is the path of a program is taken as a whole, including spaces; other text is split at spaces, without any quoting or
/// shell syntax. The program is returned as a path; empty if there is none. If a compiler is requested but missing, no other one
/// is used instead.
std::vector<std::string> find_compiler(const std::string& asked);

/// A loaded shared object; closed with its last copy.
class Library {
 public:
  Library() = default;
  explicit operator bool() const { return handle_ != nullptr; }
  /// The address of a C symbol, or null.
  void* symbol(const char* name) const;

 private:
  friend Library compile_library(const std::vector<std::string>&, const std::string&, std::string&);
  std::shared_ptr<void> handle_;
};

/// Compiles a C++20 source text for this CPU, in a PrivateFolder, and loads it; `compiler` must not be empty. If it fails the
/// result is empty and `why` gives the reason. Leaves no files behind.
Library compile_library(const std::vector<std::string>& compiler, const std::string& source, std::string& why);

}  // namespace momentree
