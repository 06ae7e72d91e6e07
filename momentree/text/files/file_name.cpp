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

std::string small_ending(std::string_view name) {
  std::string ending = std::filesystem::path(name).extension().string();
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return ending;
}

}  // namespace momentree::io
