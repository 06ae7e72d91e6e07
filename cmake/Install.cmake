# cmake --install: headers, libraries, the programs with shell completion and manual page, and the files that
# find_package(momentree) and pkg-config read. Components: program, library, and one for each plugin.
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/momentree")
set(library_targets momentree momentree_core momentree_batch)
if(TARGET momentree_generate)
  list(APPEND library_targets momentree_generate)
endif()
if(TARGET momentree_io)
  list(APPEND library_targets momentree_io momentree_sweep)
endif()
if(TARGET momentree_live)
  list(APPEND library_targets momentree_live)
endif()
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME program)
install(TARGETS ${library_targets} EXPORT momentreeTargets
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT library
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT library
  RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT library)
if(TARGET momentree-cli)
  install(TARGETS momentree-cli RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
  install(TARGETS momentree-measure RUNTIME DESTINATION "${CMAKE_INSTALL_LIBEXECDIR}")
  if(NOT CMAKE_CROSSCOMPILING)
    set(shell "${PROJECT_BINARY_DIR}/shell")
    install(FILES "${shell}/momentree.bash" DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" RENAME momentree)
    install(FILES "${shell}/_momentree" DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/site-functions")
    install(FILES "${shell}/momentree.fish" DESTINATION "${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d")
    install(FILES "${shell}/momentree.1" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1")
  endif()
endif()
# Public headers only: kernels are not installed.
include(PublicHeaders)
set(public_headers momentree/momentree.hpp momentree/batch/batch.hpp)
if(TARGET momentree_generate)
  list(APPEND public_headers momentree/generate/kernel_cache.hpp momentree/generate/source.hpp)
endif()
if(TARGET momentree_io)
  list(APPEND public_headers momentree/results/session.hpp momentree/results/results.hpp momentree/results/model_json.hpp
    momentree/scenario/part_reader.hpp momentree/results/run_record.hpp momentree/export/export.hpp momentree/sweep/run.hpp)
endif()
if(TARGET momentree_live)
  list(APPEND public_headers momentree/live/view.hpp)
endif()
momentree_public_headers(public_headers ${public_headers})
foreach(header IN LISTS public_headers)
  set(file "${PROJECT_SOURCE_DIR}/${header}")
  if(NOT EXISTS "${file}")
    set(file "${PROJECT_BINARY_DIR}/generated/${header}")
  endif()
  get_filename_component(folder "${header}" DIRECTORY)
  install(FILES "${file}" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/${folder}" COMPONENT library)
endforeach()
install(FILES docs/scenario.schema.json docs/sweep.schema.json DESTINATION "${CMAKE_INSTALL_DATADIR}/momentree")
install(FILES LICENSE NOTICE CHANGELOG.md DESTINATION "${CMAKE_INSTALL_DOCDIR}")
install(DIRECTORY scenarios/ DESTINATION "${CMAKE_INSTALL_DOCDIR}/examples/scenarios" PATTERN __pycache__ EXCLUDE)
install(FILES examples/breaking_chain.cpp DESTINATION "${CMAKE_INSTALL_DOCDIR}/examples/cpp" COMPONENT library)
install(FILES examples/installed/CMakeLists.txt DESTINATION "${CMAKE_INSTALL_DOCDIR}/examples/cpp" COMPONENT library)
install(EXPORT momentreeTargets NAMESPACE momentree:: DESTINATION "${package_dir}" COMPONENT library)
configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/momentreeConfig.cmake.in" "${PROJECT_BINARY_DIR}/momentreeConfig.cmake"
  INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/momentreeConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/momentreeConfig.cmake" "${PROJECT_BINARY_DIR}/momentreeConfigVersion.cmake"
  DESTINATION "${package_dir}" COMPONENT library)

# momentree_pkg_config(NAME DESCRIPTION REQUIRES LIBRARY…): NAME.pc, relocatable. The libraries are static, so that what they need
# is always linked.
function(momentree_pkg_config name description requires)
  list(TRANSFORM ARGN PREPEND "-lmomentree_" OUTPUT_VARIABLE libraries)
  list(JOIN libraries " " libraries)
  set(pc_folder "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
  if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}")
    set(up "${CMAKE_INSTALL_PREFIX}")
    set(libdir "${CMAKE_INSTALL_LIBDIR}")
  else()
    file(RELATIVE_PATH up "/${pc_folder}" "/")
    string(PREPEND up "\${pcfiledir}/")
    string(REGEX REPLACE "/$" "" up "${up}")
    set(libdir "\${prefix}/${CMAKE_INSTALL_LIBDIR}")
  endif()
  set(includedir "\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}")
  if(IS_ABSOLUTE "${CMAKE_INSTALL_INCLUDEDIR}")
    set(includedir "${CMAKE_INSTALL_INCLUDEDIR}")
  endif()
  set(system "-pthread")
  foreach(library IN LISTS CMAKE_DL_LIBS)
    string(APPEND system " -l${library}")
  endforeach()
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/${name}.pc" @ONLY CONTENT "prefix=@up@
libdir=@libdir@
includedir=@includedir@

Name: @name@
Description: @description@
Version: @PROJECT_VERSION@
Requires: @requires@
Cflags: -I\${includedir} -std=c++20 -pthread
Libs: -L\${libdir} @libraries@ @system@
")
  install(FILES "${PROJECT_BINARY_DIR}/${name}.pc" DESTINATION "${pc_folder}" COMPONENT library)
endfunction()
momentree_pkg_config(momentree "${PROJECT_DESCRIPTION}" "" batch core)
if(TARGET momentree_generate)
  momentree_pkg_config(momentree-generate "Code for one topology, compiled while a simulation runs" momentree generate core)
endif()
if(TARGET momentree_io)
  momentree_pkg_config(momentree-io "Scenario, model and result files, and sweeps" "momentree, expat" sweep io batch core)
endif()
if(TARGET momentree_live)
  momentree_pkg_config(momentree-live "A page in the browser that shows a running simulation" momentree-io live io core)
endif()
