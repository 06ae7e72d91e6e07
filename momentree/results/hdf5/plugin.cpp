#include <momentree/results/hdf5/plugin.hpp>

#include <dlfcn.h>
#include <unistd.h>

#include <filesystem>
#include <system_error>

#include <momentree/base/error.hpp>

namespace momentree::io {

namespace fs = std::filesystem;

namespace {

bool is_plugin_file(const std::string& path) { return ::access(path.c_str(), F_OK) == 0; }

std::string how_to_build(const PluginInfo& plugin) {
  return std::string("install ") + plugin.packages + " and build momentree again (`./dev build`); " + plugin.instead;
}

}  // namespace

std::vector<std::string> plugin_places(const char* name) {
  const std::string file = std::string("momentree-") + name + ".so";
  std::vector<std::string> places;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    places.push_back((program.parent_path() / file).string());
    places.push_back((program.parent_path() / MOMENTREE_PLUGINS_FROM_BIN / file).lexically_normal().string());
  }
  if (const std::string installed = MOMENTREE_PLUGINS "/" + file; places.empty() || places.back() != installed)
    places.push_back(installed);
  return places;
}

const void* load_plugin(const PluginInfo& plugin) {
  std::string path, searched;
  for (const std::string& place : plugin_places(plugin.name)) {
    searched += (searched.empty() ? "" : ", ") + place;
    if (path.empty() && is_plugin_file(place)) path = place;
  }
  const std::string what = std::string("momentree-") + plugin.name + ".so, which is needed for " + plugin.needed + ",";
  if (path.empty()) throw_error({what + " is missing: there is no " + searched, "", how_to_build(plugin)});
  // Open MPI loads components that use its symbols.
  void* const module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_GLOBAL);
  if (module == nullptr) {
    const char* const why = ::dlerror();
    throw_error({what + " cannot be loaded: " + (why == nullptr ? "unknown reason" : why), path, how_to_build(plugin)});
  }
  using Entry = const void* (*)();
  const auto entry = reinterpret_cast<Entry>(::dlsym(module, (std::string("momentree_plugin_") + plugin.name).c_str()));
  const void* const table = entry == nullptr ? nullptr : entry();
  if (table == nullptr) throw_error({"this is not a plugin of momentree", path, how_to_build(plugin)});
  if (const int interface = *static_cast<const int*>(table); interface != plugin.interface)
    throw_error({what + " is of another version of momentree: its interface is " + std::to_string(interface) +
                     ", and this program needs " + std::to_string(plugin.interface),
                 path, how_to_build(plugin)});
  return table;
}

}  // namespace momentree::io
