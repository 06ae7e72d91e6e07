#include <momentree/text/files/file_name.hpp>

#include <filesystem>

#include <momentree/base/characters.hpp>

namespace momentree::io {

bool leaves_folder(const std::string& name) {
  const std::filesystem::path path(name);
  int depth = 0;
  for (const std::filesystem::path& part : path) {
    if (part == "..")
      --depth;
    else if (part != ".")
      ++depth;
    if (depth < 0) return true;
  }
  return path.is_absolute() || path.has_root_name() || name.find('\\') != std::string::npos ||
         first_invisible(name) != std::string::npos;
}

}  // namespace momentree::io
