# clang and lld for wasm32-wasi: Debian's clang-19, lld-19, libc++-19-dev-wasm32, libc++abi-19-dev-wasm32,
# libclang-rt-19-dev-wasm32 and wasi-libc. Select another clang with -DMOMENTREE_CLANG=…
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
set(MOMENTREE_CLANG clang++-19 CACHE STRING "The compiler for WebAssembly")
find_program(MOMENTREE_CLANG_PATH "${MOMENTREE_CLANG}" REQUIRED)
set(CMAKE_CXX_COMPILER "${MOMENTREE_CLANG_PATH}")
set(CMAKE_CXX_COMPILER_TARGET wasm32-wasi)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES MOMENTREE_CLANG)
