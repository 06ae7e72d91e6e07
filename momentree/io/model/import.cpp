#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <momentree/io/model/model_file.hpp>
#include <momentree/io/scenario_parts.hpp>

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

XmlFile& Import::file_of(XmlElement element) {
  for (const auto& file : files_)
    if (file->has(element)) return *file;
  return *files_.front();
}

Import::Found Import::look(const std::string& name) const {
  if (!looks_at_files() || name.empty() || leaves_folder(fs::path(name), name)) return Found::nothing;
  std::error_code ignored;
  const auto status = fs::status(fs::path(folder_) / name, ignored);
  return fs::is_directory(status) ? Found::folder : fs::exists(status) ? Found::file : Found::nothing;
}

std::string Import::folder_of(const XmlFile& file) const {
  const std::string folder = fs::path(file.path()).lexically_relative(folder_).parent_path().generic_string();
  return folder.empty() ? "." : folder;
}

XmlElement Import::include(const std::string& name, const XmlSpot& at, XmlFile& from, bool again) {
  constexpr std::size_t most_files = 200;
  const auto refuse = [&](const std::string& what, const std::string& hint) {
    from.error(at, "include: " + what, hint);
    return XmlElement{};
  };
  if (name.empty()) return refuse("the name of a file is missing", "");
  if (leaves_folder(fs::path(name), name))
    return refuse(in_quotes(name) + " is not in the model's folder or below it", "copy it there");
  if (!looks_at_files()) return refuse("a model that is read from a text names no files", "read it from its file");
  const std::string path = (fs::path(folder_) / name).lexically_normal().string();
  for (const auto& file : files_)
    if (fs::path(file->path()).lexically_normal() == path)
      return again ? file->root() : refuse(in_quotes(name) + " is included already", "a file stands once in a model");
  if (files_.size() >= most_files) return refuse("more than " + std::to_string(most_files) + " files", "");
  std::string text;
  Unreadable why;
  if (!read_whole_file(path, "model", largest_model, text, why)) return refuse(in_quotes(path) + ": " + why.what, why.hint);
  files_.push_back(std::make_unique<XmlFile>(path, std::move(text)));
  return files_.back()->root();
}

bool check_name(const std::string& name, const XmlSpot& at, std::string_view what, XmlFile& file) {
  Diagnostics unheard("", "");
  if (check_bare_name(name, {}, what, unheard)) return true;  // no place is looked up for names that are fine
  return !file.out().full() && check_bare_name(name, at.place(), what, file.out());
}

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
  file.once(Severity::note, "a mesh is not in the model's folder: pictures leave it out", "the motion does not need it", at);
}

}  // namespace momentree::io
