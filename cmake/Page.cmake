# Embeds the built pages of web/ in the program as bytes, so that building it needs neither Node nor a browser.
# momentree_pages(OUTPUT FOLDER PAGE…): sets OUTPUT to sources that define PAGE_html() for each web/dist/PAGE.html, as
# FOLDER/page.hpp declares it: in momentree::cli or momentree::live.
# As a script, cmake -DNAME=… -DFOLDER=… -DPAGE=… -DSOURCE=… -P Page.cmake writes one such source.
if(CMAKE_SCRIPT_MODE_FILE)
  file(READ "${PAGE}" bytes HEX)
  string(REGEX REPLACE "(................................................................)" "\\1\"\n\"" bytes "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "\\\\x\\1" bytes "${bytes}")
  cmake_path(GET FOLDER FILENAME space)
  file(WRITE "${SOURCE}" "// Generated from ${PAGE}.
#include <${FOLDER}/page.hpp>

std::string_view momentree::${space}::${NAME}_html() {
  static constexpr char page[] =
\"${bytes}\";
  return {page, sizeof page - 1};
}
")
  return()
endif()

function(momentree_pages output folder)
  set(sources)
  foreach(name IN LISTS ARGN)
    set(page "${PROJECT_SOURCE_DIR}/web/dist/${name}.html")
    set(source "${PROJECT_BINARY_DIR}/generated/${folder}/${name}_html.cpp")
    add_custom_command(OUTPUT "${source}"
      COMMAND "${CMAKE_COMMAND}" "-DNAME=${name}" "-DFOLDER=${folder}" "-DPAGE=${page}" "-DSOURCE=${source}" -P "${PROJECT_SOURCE_DIR}/cmake/Page.cmake"
      DEPENDS "${page}" "${PROJECT_SOURCE_DIR}/cmake/Page.cmake" COMMENT "Putting the page ${name} into the program" VERBATIM)
    list(APPEND sources "${source}")
  endforeach()
  set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS -Wno-overlength-strings)
  set(${output} ${sources} PARENT_SCOPE)
endfunction()
