# Flags that make memory errors harder to exploit, as used by distributions. PRIVATE: nothing is imposed on consumers.
#   momentree_harden(TARGET [CHECKED])
# CHECKED: containers also check their bounds; for code that reads files, where the cost is not noticeable.
# tests/hardening checks the built program for their effect.
include(CheckLinkerFlag)
include(CheckPIESupported)
check_pie_supported(LANGUAGES CXX)

option(MOMENTREE_HARDENING "Stack protector, checked library calls, read-only relocations and the like" ON)
if(MOMENTREE_SANITIZE)  # sanitizers have their own checks
  set(MOMENTREE_HARDENING OFF)
endif()

set(momentree_hardening_options)
set(momentree_hardening_link_options)
# The kernels are built without the first two, which cost 3 % of a humanoid's evaluation: they neither call the C library nor
# have arrays that an external length could overrun.
set(momentree_kernel_hardening_options)
if(MOMENTREE_HARDENING)
  foreach(flag IN ITEMS stack-protector-strong stack-clash-protection cf-protection)
    string(MAKE_C_IDENTIFIER "MOMENTREE_HAS_${flag}" has)
    check_cxx_compiler_flag("-f${flag}" ${has})
    if(${has})
      list(APPEND momentree_hardening_options "-f${flag}")
    endif()
  endforeach()
  if(MOMENTREE_HAS_stack_protector_strong)
    list(APPEND momentree_kernel_hardening_options -fno-stack-protector)
  endif()
  if(MOMENTREE_HAS_stack_clash_protection)
    list(APPEND momentree_kernel_hardening_options -fno-stack-clash-protection)
  endif()
  # Needs optimisation. Overrides a value that a distribution may have set already.
  list(APPEND momentree_hardening_options -U_FORTIFY_SOURCE $<$<CONFIG:Release,RelWithDebInfo,MinSizeRel>:-D_FORTIFY_SOURCE=3>)
  list(APPEND momentree_kernel_hardening_options -U_FORTIFY_SOURCE)
  foreach(flag IN ITEMS relro now noexecstack)
    check_linker_flag(CXX "-Wl,-z,${flag}" MOMENTREE_LINKS_${flag})
    if(MOMENTREE_LINKS_${flag})
      list(APPEND momentree_hardening_link_options "-Wl,-z,${flag}")
    endif()
  endforeach()
endif()

function(momentree_harden target)
  if(NOT MOMENTREE_HARDENING)
    return()
  endif()
  target_compile_options(${target} PRIVATE ${momentree_hardening_options})
  target_link_options(${target} PRIVATE ${momentree_hardening_link_options})
  if("CHECKED" IN_LIST ARGN)
    target_compile_definitions(${target} PRIVATE $<$<NOT:$<CONFIG:Debug>>:_GLIBCXX_ASSERTIONS>)  # Debug enables them anyway
  endif()
endfunction()
