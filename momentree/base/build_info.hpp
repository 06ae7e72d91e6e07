#pragma once
// Which version of the library this is, and how it was compiled.
#include <string_view>

#include <momentree/base/version.hpp>

namespace momentree {

struct BuildInfo {
  std::string_view version;        ///< "0.1.0". Headers of another version do not fit this library; see docs/versions.md
  std::string_view compiler;       ///< "GCC 12.2.0"
  std::string_view configuration;  ///< CMake's build type: "Release"
  std::string_view flags;          ///< the options of the compiler that this configuration and MOMENTREE_NATIVE gave it
  std::string_view instructions;   ///< the widest instruction set that the library needs: "x86-64", "x86-64 with AVX2", …
  std::string_view lanes;          ///< the instruction sets of batches, the CPU's widest of which is used: "baseline avx2 avx512"
};

/// Of the linked library. Valid for ever.
const BuildInfo& build_info() noexcept;

}  // namespace momentree
