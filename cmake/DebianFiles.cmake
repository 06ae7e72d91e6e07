# Run by cpack between installing and packing: what Debian's policy wants to be named, compressed or placed otherwise.
if(NOT CPACK_GENERATOR STREQUAL "DEB")
  return()
endif()
string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)  # SOURCE_DATE_EPOCH if that is set
file(GLOB components "${CPACK_TEMPORARY_DIRECTORY}/*")
foreach(component IN LISTS components)
  cmake_path(GET component FILENAME name)
  string(TOUPPER "${name}" NAME)
  set(package "${CPACK_DEBIAN_${NAME}_PACKAGE_NAME}")
  if(package STREQUAL "")
    continue()
  endif()
  set(doc "${component}/usr/share/doc")
  file(MAKE_DIRECTORY "${doc}/${package}")
  if(NOT package STREQUAL "momentree" AND EXISTS "${doc}/momentree")
    file(GLOB files "${doc}/momentree/*")
    file(COPY ${files} DESTINATION "${doc}/${package}")
    file(REMOVE_RECURSE "${doc}/momentree")
  endif()
  set(doc "${doc}/${package}")
  file(READ "${CPACK_MOMENTREE_SOURCE}/NOTICE" notice)
  file(WRITE "${doc}/copyright" "Licensed under the Apache License, Version 2.0, which Debian systems have in
/usr/share/common-licenses/Apache-2.0.

${notice}")
  file(REMOVE "${doc}/LICENSE" "${doc}/NOTICE")
  file(WRITE "${doc}/changelog.Debian" "${package} (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium

  * Made by the project; see changelog.gz.

 -- ${CPACK_PACKAGE_CONTACT}  ${now}
")
  file(COPY_FILE "${CPACK_MOMENTREE_SOURCE}/CHANGELOG.md" "${doc}/changelog")
  file(REMOVE "${doc}/CHANGELOG.md")
  set(compressed "${doc}/changelog" "${doc}/changelog.Debian")
  file(GLOB manuals "${component}/usr/share/man/*/*.[0-9]")
  execute_process(COMMAND gzip -9nf ${compressed} ${manuals} COMMAND_ERROR_IS_FATAL ANY)
  set(overrides "${package}: initial-upload-closes-no-bugs *\n")  # not uploaded to Debian
  if(EXISTS "${component}/usr/libexec/momentree-measure")
    string(APPEND overrides "${package}: no-manual-page *usr/libexec/momentree-measure*\n")  # started by `momentree bench`
  endif()
  file(WRITE "${component}/usr/share/lintian/overrides/${package}" "${overrides}")
  set(zsh "${component}/usr/share/zsh")
  if(EXISTS "${zsh}/site-functions")
    file(RENAME "${zsh}/site-functions" "${zsh}/vendor-completions")
  endif()
endforeach()
