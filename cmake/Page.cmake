# The built page of web/ as bytes of the program: neither Node nor a browser is needed to build it.
# momentree_page(OUTPUT): sets OUTPUT to the name of a source that defines momentree::cli::report_html().
# As a script: cmake -DPAGE=… -DSOURCE=… -P Page.cmake writes that source.
if(CMAKE_SCRIPT_MODE_FILE)
  file(READ "${PAGE}" bytes HEX)
  string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  file(WRITE "${SOURCE}" "// Generated from ${PAGE}.
#include <cli/page.hpp>

namespace {
const unsigned char page[] = {
${bytes}};
}

std::string_view momentree::cli::report_html() { return {reinterpret_cast<const char*>(page), sizeof page}; }
")
  return()
endif()

function(momentree_page output)
  set(page "${PROJECT_SOURCE_DIR}/web/dist/report.html")
  set(source "${PROJECT_BINARY_DIR}/generated/cli/report_html.cpp")
  add_custom_command(OUTPUT "${source}"
    COMMAND "${CMAKE_COMMAND}" "-DPAGE=${page}" "-DSOURCE=${source}" -P "${PROJECT_SOURCE_DIR}/cmake/Page.cmake"
    DEPENDS "${page}" "${PROJECT_SOURCE_DIR}/cmake/Page.cmake" COMMENT "Putting the report's page into the program" VERBATIM)
  set(${output} "${source}" PARENT_SCOPE)
endfunction()
