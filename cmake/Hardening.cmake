# Flags that make mistakes with memory harder to exploit, as distributions set them. PRIVATE: nothing is forced on consumers.
#   momentree_harden(TARGET [CHECKED])
# CHECKED: containers check their bounds, too; for what reads files, where that costs nothing that anybody feels.
# tests/hardening reads from the program that they came through.
include(CheckLinkerFlag)
include(CheckPIESupported)
check_pie_supported(LANGUAGES CXX)

option(MOMENTREE_HARDENING "Stack protector, checked library calls, read-only relocations and the like" ON)
if(MOMENTREE_SANITIZE)  # which has checks of its own
  set(MOMENTREE_HARDENING OFF)
endif()

set(momentree_hardening_options)
set(momentree_hardening_link_options)
# The sweeps go without the first two, which take 3 % of a humanoid's evaluation: they neither call the C library nor have arrays
# that a length from outside could run over.
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
  # It needs an optimiser. Where a distribution has set it already, this is the one that counts.
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
    target_compile_definitions(${target} PRIVATE $<$<NOT:$<CONFIG:Debug>>:_GLIBCXX_ASSERTIONS>)  # Debug has it anyway
  endif()
endfunction()
