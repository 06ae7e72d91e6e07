# The program's software bill of materials (SPDX 2.3, JSON): momentree.spdx.json, written whenever the program is linked, from
# what that build used; nothing is downloaded. cmake/components.json has the information that cannot be determined.
# Each plugin has one, too: momentree-hdf5.spdx.json, momentree-mpi.spdx.json.
#   momentree_sbom(TARGET OUTPUT NAME=VERSION=FILE…)   NAME: a component whose header or static library FILE is in the target
# As a script: cmake -DOUTPUT=… -DPROGRAM=… -DVERSION=… -DREADELF=… -DHEADERS=… -DROOT=… -P Sbom.cmake
# and for the engine alone, as npm has it: cmake -DOUTPUT=… -DVERSION=… -DROOT=… -DENGINE=ON -P Sbom.cmake
if(NOT CMAKE_SCRIPT_MODE_FILE)
  function(momentree_sbom target output)
    if(NOT CMAKE_READELF)  # needed to find its libraries
      return()
    endif()
    set(plugin "")
    if(target MATCHES "^momentree-(hdf5|mpi)$")
      set(plugin "${target}")
    endif()
    add_custom_command(TARGET ${target} POST_BUILD COMMAND "${CMAKE_COMMAND}" "-DOUTPUT=${output}" "-DPROGRAM=$<TARGET_FILE:${target}>"
      "-DVERSION=${PROJECT_VERSION}" "-DREADELF=${CMAKE_READELF}" "-DHEADERS=${ARGN}" "-DPLUGIN=${plugin}" "-DROOT=${PROJECT_SOURCE_DIR}"
      -P "${PROJECT_SOURCE_DIR}/cmake/Sbom.cmake" BYPRODUCTS "${output}" COMMENT "Listing what the program is made of" VERBATIM)
    set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS "${PROJECT_SOURCE_DIR}/cmake/Sbom.cmake"
      "${PROJECT_SOURCE_DIR}/cmake/components.json" "${PROJECT_SOURCE_DIR}/web/package-lock.json")
  endfunction()
  return()
endif()
cmake_minimum_required(VERSION 3.25)

# deb_of(FILE): sets purl and version to those of the Debian package that contains a file; unchanged if there is none.
find_program(DPKG_QUERY dpkg-query)
macro(deb_of file)
  if(DPKG_QUERY AND EXISTS /etc/os-release)
    execute_process(COMMAND dpkg --print-architecture OUTPUT_VARIABLE machine OUTPUT_STRIP_TRAILING_WHITESPACE)
    execute_process(COMMAND "${DPKG_QUERY}" -S "${file}" OUTPUT_VARIABLE owners ERROR_QUIET)
    file(READ /etc/os-release system)
    string(REGEX MATCH "(^|\n)ID=\"?([a-z0-9.-]+)" system "${system}")
    set(system "${CMAKE_MATCH_2}")
    string(REGEX MATCH "[^:\n]+:${machine}: " package "${owners}")
    if(package STREQUAL "")
      string(REGEX MATCH "^[^:\n]+: " package "${owners}")
    endif()
    if(NOT package STREQUAL "")
      string(REGEX REPLACE ": $" "" package "${package}")
      execute_process(COMMAND "${DPKG_QUERY}" -W -f "\${Version}" "${package}" OUTPUT_VARIABLE debian)
      string(REGEX REPLACE ":.*" "" package "${package}")
      set(purl "pkg:deb/${system}/${package}@${debian}?arch=${machine}")
      string(REPLACE "+" "%2B" purl "${purl}")
      if(version STREQUAL "")
        string(REGEX REPLACE "^[0-9]+:|-[^-]*$" "" version "${debian}")  # the upstream version
      endif()
      set(supplier "Organization: ${system}")
    endif()
  endif()
endmacro()

set(packages "")
set(relations "")
# add_package(ID FROM RELATION): adds a package from the variables name, version, purl, supplier, license, copyright and home.
macro(add_package id from relation)
  string(APPEND packages ",\n    {\"SPDXID\": \"SPDXRef-${id}\", \"name\": \"${name}\",\n")
  if(NOT version STREQUAL "")
    string(APPEND packages "     \"versionInfo\": \"${version}\",\n")
  endif()
  if(NOT purl STREQUAL "")
    string(APPEND packages "     \"externalRefs\": [{\"referenceCategory\": \"PACKAGE-MANAGER\", \"referenceType\": \"purl\", "
      "\"referenceLocator\": \"${purl}\"}],\n")
  endif()
  string(APPEND packages "     \"supplier\": \"${supplier}\", \"downloadLocation\": \"NOASSERTION\", \"homepage\": \"${home}\", \"filesAnalyzed\": false,\n"
    "     \"licenseConcluded\": \"${license}\", \"licenseDeclared\": \"${license}\",\n     \"copyrightText\": \"${copyright}\"}")
  string(APPEND relations ",\n    {\"spdxElementId\": \"SPDXRef-${from}\", \"relationshipType\": \"${relation}\", "
    "\"relatedSpdxElement\": \"SPDXRef-${id}\"}")
endmacro()

file(READ "${ROOT}/cmake/components.json" known)
file(READ "${ROOT}/web/package-lock.json" lock)

# The project's own parts: the program, the pages in it, and the engine in one of these.
string(JSON license GET "${known}" own license)
string(JSON copyright GET "${known}" own copyright)
string(JSON home GET "${known}" own home)
set(version "${VERSION}")
set(purl "")
set(supplier "Organization: the momentree authors")
set(name "momentree")
if(PLUGIN)
  set(name "${PLUGIN}")
elseif(ENGINE)
  set(name "momentree engine")
  set(purl "pkg:npm/momentree@${VERSION}")
endif()
set(engine engine)  # what contains the components of the engine
if(ENGINE)
  set(engine momentree)
endif()
add_package(momentree DOCUMENT DESCRIBES)
set(purl "")
if(NOT PLUGIN AND NOT ENGINE)
  set(name "momentree pages")
  add_package(pages momentree CONTAINS)
  set(name "momentree engine")
  add_package(engine pages CONTAINS)
endif()

# Third-party components.
set(needed "")
if(READELF AND NOT ENGINE)
  execute_process(COMMAND "${READELF}" -dW "${PROGRAM}" OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX REPLACE "[][]" "|" dynamic "${dynamic}")  # brackets would join list elements
  string(REGEX MATCHALL "NEEDED[^|]*[|][^|]*" needed "${dynamic}")
  list(TRANSFORM needed REPLACE ".*[|]" "")
endif()
set(headers ${HEADERS})
string(JSON count LENGTH "${known}" components)
math(EXPR last "${count} - 1")
foreach(i RANGE ${last})
  foreach(field IN ITEMS name id in license home copyright library npm pypi)
    string(JSON ${field} ERROR_VARIABLE absent GET "${known}" components ${i} ${field})
    if(absent)
      set(${field} "")
    endif()
  endforeach()
  if(id STREQUAL "")
    string(REPLACE "+" "p" id "${name}")
  endif()
  set(version "")
  set(purl "")
  set(supplier "NOASSERTION")
  set(contained FALSE)
  if(in MATCHES "^(header|shared)$")  # a library that is usually shared may be linked statically
    foreach(header IN LISTS headers)
      if(header MATCHES "^([^=]+)=([^=]*)=(.*)$" AND CMAKE_MATCH_1 STREQUAL name)
        set(version "${CMAKE_MATCH_2}")
        if(NOT pypi STREQUAL "")
          set(purl "pkg:pypi/${pypi}@${version}")
        endif()
        deb_of("${CMAKE_MATCH_3}")
        add_package(${id} momentree CONTAINS)
        list(REMOVE_ITEM headers "${header}")
        set(contained TRUE)
        break()
      endif()
    endforeach()
  endif()
  if(contained OR in STREQUAL "header" OR (PLUGIN AND NOT in STREQUAL "shared") OR (ENGINE AND NOT in STREQUAL "engine"))
    continue()
  elseif(in STREQUAL "shared")
    set(libraries ${needed})
    list(FILTER libraries INCLUDE REGEX "${library}")
    if(libraries)
      list(GET libraries 0 first)
      deb_of("*/${first}")
      add_package(${id} momentree DYNAMIC_LINK)
      list(REMOVE_ITEM needed ${libraries})
    endif()
  elseif(in STREQUAL "page")
    string(JSON version GET "${lock}" packages "node_modules/${npm}" version)
    set(purl "pkg:npm/${npm}@${version}")
    add_package(${id} pages CONTAINS)
  else()
    add_package(${id} ${engine} CONTAINS)
  endif()
endforeach()
if(needed OR headers)
  message(FATAL_ERROR "the program contains what cmake/components.json does not list: ${needed} ${headers}")
endif()

# Licences without an SPDX identifier.
set(texts "")
string(JSON count LENGTH "${known}" licenses)
math(EXPR last "${count} - 1")
foreach(i RANGE ${last})
  string(JSON id GET "${known}" licenses ${i} id)
  string(JSON text GET "${known}" licenses ${i} text)
  string(APPEND texts ",\n    {\"licenseId\": \"${id}\", \"extractedText\": \"${text}\"}")
endforeach()

string(SUBSTRING "${packages}" 2 -1 packages)
string(SUBSTRING "${relations}" 2 -1 relations)
string(SUBSTRING "${texts}" 2 -1 texts)
string(SHA256 hash "${packages}${relations}${texts}")
string(SUBSTRING "${hash}" 0 32 hash)
set(namespace "https://spdx.org/spdxdocs/momentree-${VERSION}-${hash}")
if(EXISTS "${OUTPUT}")  # unchanged content keeps its date
  file(READ "${OUTPUT}" before)
  string(FIND "${before}" "\"${namespace}\"" same)
  if(NOT same EQUAL -1)
    return()
  endif()
endif()
string(TIMESTAMP now "%Y-%m-%dT%H:%M:%SZ" UTC)  # SOURCE_DATE_EPOCH if that is set
file(WRITE "${OUTPUT}" "{
  \"spdxVersion\": \"SPDX-2.3\",
  \"dataLicense\": \"CC0-1.0\",
  \"SPDXID\": \"SPDXRef-DOCUMENT\",
  \"name\": \"momentree-${VERSION}\",
  \"documentNamespace\": \"${namespace}\",
  \"creationInfo\": {\"created\": \"${now}\", \"creators\": [\"Tool: momentree-${VERSION} cmake/Sbom.cmake\"]},
  \"packages\": [
${packages}
  ],
  \"relationships\": [
${relations}
  ],
  \"hasExtractedLicensingInfos\": [
${texts}
  ]
}
")
