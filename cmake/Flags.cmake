# Nothing here reaches consumers: public headers contain no kernels, so user code may be compiled with any flags.

include(CheckCXXCompilerFlag)

# For the library and everything in this project that includes its kernels: all must compile them alike (one-definition rule).
add_library(momentree_kernels INTERFACE)
target_compile_definitions(momentree_kernels INTERFACE MOMENTREE_KERNELS)
# sqrt must not set errno; otherwise the compiler adds a library call to every square root.
target_compile_options(momentree_kernels INTERFACE -fno-math-errno)
if(MOMENTREE_NATIVE)
  check_cxx_compiler_flag(-march=native MOMENTREE_HAS_MARCH_NATIVE)
  if(MOMENTREE_HAS_MARCH_NATIVE)
    target_compile_options(momentree_kernels INTERFACE -march=native)
  endif()
endif()
# Every compiler gets the same bits, for every CPU (ADR 7). g++ 12 still fuses multiply-adds in vectorised scalar code.
target_compile_options(momentree_kernels INTERFACE -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(momentree_kernels INTERFACE -fno-tree-slp-vectorize)
endif()
if(MOMENTREE_SANITIZE)
  add_compile_options(-fsanitize=${MOMENTREE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${MOMENTREE_SANITIZE})
endif()

# For targets that include kernels.
function(momentree_flags target)
  momentree_warnings(${target})
  target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:momentree_kernels>)
endfunction()

# For targets that include public headers only, as consumers do.
function(momentree_warnings target)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  # -Wrestrict of g++ 12 reports false overlaps in std::string's operator+. Compilers warn that packs wider than the CPU's registers
  # are passed through memory, even if everything is inlined.
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wno-psabi
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
  if(MOMENTREE_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()

# Precompiles the headers that nearly every source file of the target includes, or REUSE_FROM another target with the same flags.
function(momentree_precompile target)
  if(ARGV1 STREQUAL REUSE_FROM)
    target_precompile_headers(${target} ${ARGN})
  else()
    target_precompile_headers(${target} PRIVATE <algorithm> <array> <cmath> <cstdint> <functional> <memory> <optional> <span> <string>
      <string_view> <unordered_map> <utility> <vector> ${ARGN})
  endif()
  # With precompiled headers g++ 12 no longer recognises system headers and warns about the standard library.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow$<SEMICOLON>-Wno-stringop-overread$<SEMICOLON>-Wno-array-bounds>)
endfunction()

# For readers, writers and the command line, which are limited by file access: optimises for compile time.
function(momentree_fast_build target)
  momentree_precompile(${target} ${ARGN})
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# CMake's Release has -O3; Debug enables the assertions of the standard library.
add_compile_definitions($<$<CONFIG:Debug>:_GLIBCXX_ASSERTIONS>)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND PROJECT_IS_TOP_LEVEL AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CCACHE_PROGRAM}")
endif()
