#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <momentree/io/model/importer.hpp>

namespace momentree::io {

namespace fs = std::filesystem;

Import::Import(std::string path, std::string text, std::string folder) : folder_(std::move(folder)) {
  files_.push_back(std::make_unique<XmlFile>(std::move(path), std::move(text)));
}

std::size_t Import::errors() const {
  std::size_t count = 0;
  for (const auto& file : files_) count += file->out().errors();
  return count;
}

namespace {

// A path without the `scheme://package/` that a library of the robot's maker would resolve.
std::string without_scheme(const std::string& name, bool& in_package) {
  const std::size_t colon = name.find("://");
  if (colon == std::string::npos) return name;
  const std::string scheme = name.substr(0, colon), rest = name.substr(colon + 3);
  in_package = scheme == "package" || scheme == "model";
  return rest;
}

bool leaves_folder(const fs::path& path, const std::string& text) {
  int depth = 0;
  for (const fs::path& part : path) {
    if (part == "..")
      --depth;
    else if (part != ".")
      ++depth;
    if (depth < 0) return true;
  }
  return path.is_absolute() || path.has_root_name() || text.find('\\') != std::string::npos ||
         text.find('\0') != std::string::npos;
}

}  // namespace

void Import::read_mesh(const std::string& name, const XmlSpot& at, Shape& shape, XmlFile& file) {
  bool in_package = false;
  const std::string rest = without_scheme(name, in_package);
  const fs::path path(rest);
  if (rest.empty()) {
    file.error(at, "a mesh has no file's name");
    return;
  }
  if (leaves_folder(path, rest)) {
    file.error(at, "mesh " + in_quotes(name) + " is not in the model's folder or below it", "copy it there, or leave it out");
    return;
  }
  shape.kind = Shape::Kind::mesh;
  shape.mesh = rest;
  if (!looks_at_files()) return;
  // In the folder as the path says, or without the package's name.
  std::error_code ignored;
  std::vector<fs::path> tried{path};
  if (in_package) tried.push_back(path.lexically_relative(*path.begin()));
  for (const fs::path& each : tried) {
    if (!fs::is_regular_file(fs::path(folder_) / each, ignored)) continue;
    shape.mesh = each.generic_string();
    return;
  }
  file.once(Severity::warning, "a mesh is not in the model's folder: pictures leave it out", "the motion does not need it", at);
}

}  // namespace momentree::io
