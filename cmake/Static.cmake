# MOMENTREE_STATIC: programs and the Python extension that need no shared library but those of glibc, of version 2.34 or later on
# x86-64 and 2.35 elsewhere.
#   momentree_link_static(TARGET)   nothing if MOMENTREE_STATIC is off
# static_components: what they contain then, for momentree_sbom.
set(static_components "")
if(MOMENTREE_STATIC)
  list(APPEND static_components "expat=${EXPAT_VERSION_STRING}=${EXPAT_LIBRARY}")
  foreach(library IN ITEMS libstdc++=libstdc++.a libgcc=libgcc_eh.a)
    string(REGEX REPLACE ".*=" "" file "${library}")
    string(REGEX REPLACE "=.*" "" name "${library}")
    execute_process(COMMAND "${CMAKE_CXX_COMPILER}" -print-file-name=${file} OUTPUT_VARIABLE file OUTPUT_STRIP_TRAILING_WHITESPACE)
    list(APPEND static_components "${name}=${CMAKE_CXX_COMPILER_VERSION}=${file}")
  endforeach()
endif()

function(momentree_link_static target)
  if(MOMENTREE_STATIC)
    target_link_options(${target} PRIVATE -static-libstdc++ -static-libgcc)
    if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
      target_link_options(${target} PRIVATE -Wl,--wrap=hypot)
    endif()
    target_sources(${target} PRIVATE "${PROJECT_SOURCE_DIR}/cli/static/older_glibc.cpp")
  endif()
endfunction()
