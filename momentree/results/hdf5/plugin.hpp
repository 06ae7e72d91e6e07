#pragma once
// Optional parts of the program that need further libraries: shared modules, loaded when they are needed.
#include <string>
#include <vector>

namespace momentree::io {

/// A plugin is the file momentree-NAME.so. It exports the C function momentree_plugin_NAME(), which returns a table of C
/// functions whose first member, an int, is the version of the interface. No C++ types or exceptions cross that interface, so the
/// compilers and standard libraries of the two sides need not match.
struct PluginInfo {
  const char* name;      ///< "hdf5"
  int interface;         ///< the version that the program needs
  const char* needed;    ///< for what: "HDF5 files"
  const char* packages;  ///< Debian packages that building it needs
  const char* instead;   ///< what works without it
};

/// The table of a plugin, which stays loaded. Throws Error, with a hint how to get it, if it is missing, cannot be loaded or has
/// another version of the interface.
const void* load_plugin(const PluginInfo& plugin);

/// The places where a plugin is searched for, in this order: the folder of the program, the folder of plugins relative to it, as
/// installed, and that of the installation prefix.
std::vector<std::string> plugin_places(const char* name);

}  // namespace momentree::io
