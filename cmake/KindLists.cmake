# Generates two headers from a drop-in folder: a list (an X macro over its files, alphabetical) and an umbrella header that
# includes them all. A new kind is one new file; its type is the CamelCase of the file's name (rk4.hpp → Rk4).

function(momentree_kind_list folder macro list_header umbrella_header)
  file(GLOB headers CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}/${folder}" "${PROJECT_SOURCE_DIR}/${folder}/*.hpp")
  list(SORT headers)
  set(rows "")
  set(includes "")
  foreach(header IN LISTS headers)
    string(REGEX REPLACE "\\.hpp$" "" name "${header}")
    string(REPLACE "_" ";" words "${name}")
    set(type "")
    foreach(word IN LISTS words)
      string(SUBSTRING "${word}" 0 1 first)
      string(SUBSTRING "${word}" 1 -1 rest)
      string(TOUPPER "${first}" first)
      string(APPEND type "${first}${rest}")
    endforeach()
    string(APPEND rows " \\\n  X(${name}, ${type})")
    string(APPEND includes "#include <${folder}/${header}>\n")
  endforeach()
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/generated/${list_header}"
    CONTENT "#pragma once\n// Generated from the files in ${folder}/: X(name, Type), in alphabetical order.\n#define ${macro}(X)${rows}\n" @ONLY)
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/generated/${umbrella_header}"
    CONTENT "#pragma once\n// Generated: every file in ${folder}/.\n${includes}" @ONLY)
endfunction()

momentree_kind_list(momentree/joint/kinds MOMENTREE_KINDS momentree/joint/kind_list.hpp momentree/joint/kinds.hpp)
momentree_kind_list(momentree/integrate/kinds MOMENTREE_METHODS momentree/integrate/method_list.hpp momentree/integrate/methods.hpp)
momentree_kind_list(momentree/model/elements MOMENTREE_ELEMENTS momentree/model/element_list.hpp momentree/model/all_elements.hpp)
momentree_kind_list(momentree/simulate/actions MOMENTREE_ACTIONS momentree/simulate/action_list.hpp momentree/simulate/all_actions.hpp)
momentree_kind_list(momentree/simulate/quantities MOMENTREE_QUANTITIES momentree/simulate/quantity_list.hpp momentree/simulate/all_quantities.hpp)
momentree_kind_list(momentree/models/importers MOMENTREE_IMPORTERS momentree/models/importers/list.hpp momentree/models/all_importers.hpp)
