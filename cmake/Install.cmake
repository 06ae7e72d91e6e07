# cmake --install: headers, libraries, the programs with shell completion and manual page, and the files that
# find_package(momentree) reads.
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/momentree")
set(library_targets momentree momentree_core momentree_batch)
if(TARGET momentree_generate)
  list(APPEND library_targets momentree_generate)
endif()
if(TARGET momentree_io)
  list(APPEND library_targets momentree_io)
endif()
install(TARGETS ${library_targets} EXPORT momentreeTargets
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
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
install(DIRECTORY momentree "${PROJECT_BINARY_DIR}/generated/momentree" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
  FILES_MATCHING PATTERN "*.hpp" PATTERN "*.ipp" PATTERN "test_support.hpp" EXCLUDE)
install(FILES docs/scenario.schema.json DESTINATION "${CMAKE_INSTALL_DATADIR}/momentree")
install(FILES LICENSE NOTICE DESTINATION "${CMAKE_INSTALL_DOCDIR}")
install(EXPORT momentreeTargets NAMESPACE momentree:: DESTINATION "${package_dir}")
configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/momentreeConfig.cmake.in" "${PROJECT_BINARY_DIR}/momentreeConfig.cmake"
  INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/momentreeConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/momentreeConfig.cmake" "${PROJECT_BINARY_DIR}/momentreeConfigVersion.cmake"
  DESTINATION "${package_dir}")
