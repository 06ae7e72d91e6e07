#pragma once
// Generated source as a library of this process.
#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include <doctest/doctest.h>

namespace momentree::test {

/// Compiled by the compiler of the tests, also with these flags; a warning is an error.
class CompiledSource {
 public:
  explicit CompiledSource(const std::string& source, const std::string& flags = "") {
    std::string folder = (std::filesystem::temp_directory_path() / "momentree-source-XXXXXX").string();
    REQUIRE(mkdtemp(folder.data()) != nullptr);
    std::ofstream(folder + "/code.cpp") << source;
    const std::string command = "'" MOMENTREE_COMPILER "' -std=c++20 -O1 -march=native -fPIC -shared -Werror " + flags + " '" +
                                folder + "/code.cpp' -o '" + folder + "/code.so'";
    CHECK_MESSAGE(std::system(command.c_str()) == 0, source);
    handle_ = dlopen((folder + "/code.so").c_str(), RTLD_NOW | RTLD_LOCAL);
    std::filesystem::remove_all(folder);
    REQUIRE(handle_ != nullptr);
  }
  CompiledSource(const CompiledSource&) = delete;
  CompiledSource& operator=(const CompiledSource&) = delete;
  ~CompiledSource() { dlclose(handle_); }

  template <class F>
  F function(const char* name) const {
    void* const found = dlsym(handle_, name);
    REQUIRE(found != nullptr);
    return reinterpret_cast<F>(found);
  }

 private:
  void* handle_ = nullptr;
};

}  // namespace momentree::test
