#pragma once
// toml++ has a function that opens files, which nothing calls here; libc++ for WebAssembly has file streams, but keeps them back
// where there are no folders. Included before anything else of the one file that includes toml++.
#include <__config>

#undef _LIBCPP_HAS_NO_FILESYSTEM
#include <fstream>
