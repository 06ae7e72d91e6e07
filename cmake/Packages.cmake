# cpack in a build folder: `cpack -G DEB` writes Debian packages, `cpack -G TGZ` an archive of the program. `./dev package` makes
# both as they are published.
set(CPACK_PACKAGE_NAME momentree)
set(CPACK_PACKAGE_VENDOR "the momentree authors")
set(CPACK_PACKAGE_CONTACT "the momentree authors <authors@momentree.invalid>" CACHE STRING "Maintainer of Debian packages: NAME <ADDRESS>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
string(TOLOWER "${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR}" system)
set(CPACK_ARCHIVE_FILE_NAME "momentree-${PROJECT_VERSION}-${system}")
set(CPACK_PACKAGE_FILE_NAME "${CPACK_ARCHIVE_FILE_NAME}")

set(deb_components library)
if(TARGET momentree-cli)
  list(APPEND deb_components program)
endif()
foreach(plugin hdf5 mpi)
  if(TARGET momentree-${plugin})
    list(APPEND deb_components ${plugin})
  endif()
endforeach()
set(CPACK_COMPONENTS_ALL ${deb_components})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(about "It simulates mechanisms whose topology changes while they move: joints
break, jam, come free or turn into another kind of joint, and bodies fall
off, are grasped, docked, welded or released. Momentum is conserved to
round-off across every change; energy is conserved too, or the loss is
reported.
")
# CPack indents the lines of a description and marks the empty ones.
function(deb component package section)
  string(TOUPPER "${component}" COMPONENT)
  list(JOIN ARGN "\n" text)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME "${package}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_SECTION "${section}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${COMPONENT}_DESCRIPTION "${about}\n${text}" PARENT_SCOPE)
endfunction()
deb(program momentree science "This package has the command momentree.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "momentree-hdf5, momentree-mpi, libmomentree-dev")
deb(library libmomentree-dev libdevel "This package has the headers and static libraries of C++, with files for"
  "find_package(momentree) and pkg-config.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "libexpat1-dev")
deb(hdf5 momentree-hdf5 science "This package has the plugin for results as HDF5 files:" "`momentree run --format hdf5`.")
deb(mpi momentree-mpi science "This package has the plugin for sweeps on several machines, with MPI.")
foreach(PLUGIN HDF5 MPI)
  set(CPACK_DEBIAN_${PLUGIN}_PACKAGE_DEPENDS "momentree (= ${PROJECT_VERSION}-1)")
endforeach()

set(CPACK_PRE_BUILD_SCRIPTS "${CMAKE_CURRENT_LIST_DIR}/DebianFiles.cmake")
set(CPACK_PROJECT_CONFIG_FILE "${CMAKE_CURRENT_LIST_DIR}/PackageKinds.cmake")
set(CPACK_MOMENTREE_SOURCE "${PROJECT_SOURCE_DIR}")
include(CPack)
