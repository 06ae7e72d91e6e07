# The source text of the engine's sine and cosine, which is copied into generated kernels: one source for both.
set(sincos_file "${PROJECT_SOURCE_DIR}/momentree/math/sincos.hpp")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${sincos_file}")
file(READ "${sincos_file}" sincos_source)
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/generated/momentree/generate/sincos_text.hpp" CONTENT
  "#pragma once\n// Generated from momentree/math/sincos.hpp.\ninline constexpr const char* momentree_sincos_text = R\"momentree(@sincos_source@)momentree\";\n" @ONLY)
