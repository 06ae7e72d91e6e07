# How this build is made, for base/build_info.hpp and `momentree --version`; and the commit that it is made from.
#   momentree_commit(TARGET…)  lets these targets include <cli/commit.hpp>, which every build renews if the commit is another one
# As a script: cmake -DROOT=… -DOUTPUT=… [-DGIT=…] -P BuildInfo.cmake writes that header.
if(CMAKE_SCRIPT_MODE_FILE)
  set(commit "")
  file(READ "${ROOT}/cmake/commit.txt" archived)  # `git archive` writes the commit into it
  if(archived MATCHES "^[0-9a-f]+")
    set(commit "${CMAKE_MATCH_0}")
  elseif(GIT AND EXISTS "${ROOT}/.git")  # a file in worktrees
    execute_process(COMMAND "${GIT}" -C "${ROOT}" rev-parse HEAD OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE
      ERROR_QUIET RESULT_VARIABLE failed)
    execute_process(COMMAND "${GIT}" -C "${ROOT}" --no-optional-locks status --porcelain --untracked-files=no OUTPUT_VARIABLE changes
      ERROR_QUIET)
    if(failed)
      set(commit "")
    elseif(NOT changes STREQUAL "")
      string(APPEND commit " with changes")
    endif()
  endif()
  file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#pragma once\n// Generated. The commit that this build is made from; empty if it is not known.
namespace momentree::cli {
inline constexpr char commit[] = \"${commit}\";
}\n" @ONLY)
  return()
endif()

set(momentree_all_flags "${CMAKE_CXX_FLAGS}")
if(CMAKE_BUILD_TYPE)
  string(TOUPPER "${CMAKE_BUILD_TYPE}" type)
  string(APPEND momentree_all_flags " ${CMAKE_CXX_FLAGS_${type}}")
endif()
get_target_property(options momentree_kernels INTERFACE_COMPILE_OPTIONS)
list(JOIN options " " options)
string(APPEND momentree_all_flags " ${options}")
string(STRIP "${momentree_all_flags}" momentree_all_flags)
list(JOIN momentree_lanes " " momentree_lanes_text)
configure_file("${CMAKE_CURRENT_LIST_DIR}/version.hpp.in" "${PROJECT_BINARY_DIR}/generated/momentree/base/version.hpp" @ONLY)
configure_file("${CMAKE_CURRENT_LIST_DIR}/build_settings.hpp.in" "${PROJECT_BINARY_DIR}/generated/momentree/base/build_settings.hpp" @ONLY)

set(momentree_build_info "${CMAKE_CURRENT_LIST_FILE}")
function(momentree_commit)
  find_program(MOMENTREE_GIT git)
  set(header "${PROJECT_BINARY_DIR}/generated/cli/commit.hpp")
  if(NOT TARGET momentree_commit)
    add_custom_target(momentree_commit COMMAND "${CMAKE_COMMAND}" "-DROOT=${PROJECT_SOURCE_DIR}" "-DOUTPUT=${header}" "-DGIT=${MOMENTREE_GIT}"
      -P "${momentree_build_info}" BYPRODUCTS "${header}" COMMENT "" VERBATIM)
  endif()
  foreach(target IN LISTS ARGN)
    add_dependencies(${target} momentree_commit)
    target_include_directories(${target} PRIVATE "${PROJECT_BINARY_DIR}/generated")
  endforeach()
endfunction()
