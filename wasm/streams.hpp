#pragma once
// toml++ has a function that opens files, which nothing calls here; libc++ for WebAssembly has file streams but disables them on
// systems without a file system. Included before everything else in the one file that includes toml++.
#include <__config>

#undef _LIBCPP_HAS_NO_FILESYSTEM
#include <fstream>
