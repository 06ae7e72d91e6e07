#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/models/import/model_file.hpp>
#include <momentree/models/mesh/read_mesh.hpp>
#include <momentree/models/mesh/source.hpp>
#include <momentree/text/files/file_name.hpp>

namespace momentree::io {

namespace fs = std::filesystem;

std::size_t Import::errors() const {
  std::size_t count = 0;
  for (const auto& file : files_) count += file->out().errors();
  return count;
}

namespace {

// A path without its `scheme://` prefix, which a ROS installation would resolve. `package:///name/` is common for
// `package://name/`.
std::string without_scheme(const std::string& name, bool& in_package) {
  const std::size_t colon = name.find("://");
  if (colon == std::string::npos) return name;
  const std::string scheme = name.substr(0, colon);
  std::size_t rest = colon + 3;
  in_package = scheme == "package" || scheme == "model";
  if (in_package) rest = std::min(name.find_first_not_of('/', rest), name.size());
  return name.substr(rest);
}

fs::path real_path(const std::string& path) {
  std::error_code failed;
  fs::path real = fs::canonical(path, failed);
  return failed ? fs::path(path) : real;
}

}  // namespace

Import::Import(std::string path, std::string text, std::string folder, bool quotes) : folder_(std::move(folder)) {
  if (looks_at_files()) {
    enclosure_ = Enclosure(path);
    real_paths_.push_back(real_path(path));
  }
  files_.push_back(std::make_unique<XmlFile>(std::move(path), std::move(text), quotes));
}

XmlFile& Import::file_of(XmlElement element) {
  for (const auto& file : files_)
    if (file->has(element)) return *file;
  return *files_.front();
}

Import::Found Import::probe(const std::string& name) const {
  if (!looks_at_files() || name.empty() || leaves_folder(name)) return Found::nothing;
  const fs::path path = fs::path(folder_) / name;
  if (!enclosure_.holds(path)) return Found::nothing;
  std::error_code ignored;
  const auto status = fs::status(path, ignored);
  return fs::is_directory(status) ? Found::folder : fs::exists(status) ? Found::file : Found::nothing;
}

std::string Import::folder_of(const XmlFile& file) const {
  const std::string folder = fs::path(file.path()).lexically_relative(folder_).parent_path().generic_string();
  return folder.empty() ? "." : folder;
}

XmlElement Import::include(const std::string& name, const XmlLocation& at, XmlFile& from, bool again) {
  constexpr std::size_t most_files = 200;
  const auto refuse = [&](const std::string& what, const std::string& hint) {
    from.error(at, "include: " + what, hint);
    return XmlElement{};
  };
  if (name.empty()) return refuse("the name of a file is missing", "");
  if (leaves_folder(name)) return refuse(in_quotes(name) + " is not in the model's folder or below it", "copy it there");
  if (!looks_at_files()) return refuse("a model read from text cannot name files", "read it from its file");
  const std::string path = (fs::path(folder_) / name).lexically_normal().string();
  if (!enclosure_.holds(path))
    return refuse(in_quotes(name) + " leads out of the model's folder through a symbolic link", "copy the file there");
  const fs::path real = real_path(path);
  if (const auto known = std::find(real_paths_.begin(), real_paths_.end(), real); known != real_paths_.end())
    return again ? files_[static_cast<std::size_t>(known - real_paths_.begin())]->root()
                 : refuse(in_quotes(name) + " is included already", "a model can include a file only once");
  if (files_.size() >= most_files) return refuse("more than " + std::to_string(most_files) + " files", "");
  std::string text;
  Unreadable why;
  if (!read_whole_file(path, "model", largest_model, text, why)) return refuse(in_quotes(path) + ": " + why.what, why.hint);
  const bool quotes = begins_as_model(text);
  files_.push_back(std::make_unique<XmlFile>(path, std::move(text), quotes));
  real_paths_.push_back(real);
  return files_.back()->root();
}

bool check_name(const std::string& name, const XmlLocation& at, std::string_view what, XmlFile& file) {
  Diagnostics unheard("", "");
  if (check_bare_name(name, {}, what, unheard)) return true;  // valid names need no place
  return !file.out().full() && check_bare_name(name, at.place(), what, file.out());
}

namespace {

std::shared_ptr<const MeshSource> mesh_source(const fs::path& path, const std::string& submesh, const XmlLocation& at,
                                              const XmlFile& file) {
  return std::make_shared<MeshSource>(MeshSource{path.lexically_normal().string(), submesh, "", {}, file.path(), at.place()});
}

// The folder of the package `name` that contains a folder: one of its parents of that name that is marked as a package. Empty if
// there is none.
fs::path package_of(const fs::path& folder, const std::string& name) {
  std::error_code failed;
  const fs::path real = fs::canonical(folder, failed);
  if (failed || name.empty()) return {};
  for (fs::path at = real; at.has_relative_path(); at = at.parent_path())
    if (at.filename() == name &&
        (fs::is_regular_file(at / "package.xml", failed) || fs::is_regular_file(at / "model.config", failed)))
      return at;
  return {};
}

}  // namespace

std::shared_ptr<const HeightGrid> Import::read_heights(const std::string& name, const XmlLocation& at, XmlFile& file) const {
  bool in_package = false;
  const fs::path path = without_scheme(name, in_package);
  const auto refuse = [&](const std::string& what, const std::string& hint) {
    file.warning(at, "the height field " + in_quotes(name) + " " + what + ": nothing touches it", hint);
    return nullptr;
  };
  if (!looks_at_files()) return refuse("is not read: a model read from text cannot name files", "read it from its file");
  std::vector<fs::path> tried{path};
  if (in_package && !path.empty() && std::next(path.begin()) != path.end())
    tried.push_back(path.lexically_relative(*path.begin()));
  for (const fs::path& each : tried) {
    const fs::path whole = fs::path(folder_) / each;
    if (leaves_folder(each.generic_string()) || !enclosure_.holds(whole)) continue;
    if (const auto reason = why_unreadable(whole.string(), "height field")) {
      if (!reason->missing) return refuse(reason->what, reason->hint);
      continue;
    }
#ifdef __cpp_exceptions
    try {
      const bool image = each.extension() == ".png" || each.extension() == ".PNG";
      return std::make_shared<const HeightGrid>(image ? read_height_image(whole.string()) : read_height_file(whole.string()));
    } catch (const Error& error) {
      return refuse(error.problem, error.hint);
    }
#endif
  }
  return refuse("is not in the model's folder or below it", "copy it there");
}

void Import::read_mesh(const std::string& name, const XmlLocation& at, Shape& shape, XmlFile& file, const std::string& submesh) {
  bool in_package = false;
  const std::string rest = without_scheme(name, in_package);
  if (rest.empty()) {
    file.error(at, "a mesh has no file name");
    return;
  }
  if (leaves_folder(rest)) {
    file.once(Severity::note, "a mesh is not in the model's folder or below it: pictures leave it out",
              "the motion does not depend on it", at);
    return;
  }
  shape.kind = Shape::Kind::mesh;
  shape.mesh = rest;
  if (!looks_at_files()) return;
  // In the folder as the path says, or without the package's name.
  const fs::path path(rest);
  std::vector<fs::path> tried{path};
  if (in_package && std::next(path.begin()) != path.end()) tried.push_back(path.lexically_relative(*path.begin()));
  std::string why;  // if the file exists
  for (const fs::path& each : tried) {
    const fs::path file_path = fs::path(folder_) / each;
    if (!enclosure_.holds(file_path)) {
      why = "leads out of the model's folder through a symbolic link";
      continue;
    }
    const auto reason = why_unreadable(file_path.string(), "mesh");
    if (!reason) {
      shape.mesh = each.generic_string();
      shape.source = mesh_source(file_path, submesh, at, file);
      return;
    }
    if (!reason->missing) why = reason->what;
  }
  // A model in a package, whose meshes are next to its folder.
  if (in_package && is_mesh_name(rest)) {
    const fs::path package = package_of(folder_, path.begin()->string());
    const fs::path file_path = package / path.lexically_relative(*path.begin());
    if (!package.empty() && Enclosure((package / "package.xml").string()).holds(file_path) &&
        !why_unreadable(file_path.string(), "mesh")) {
      std::error_code failed;
      const fs::path relative = fs::proximate(file_path, folder_, failed);
      shape.mesh = failed ? rest : relative.generic_string();
      shape.source = mesh_source(fs::path(folder_) / relative, submesh, at, file);
      return;
    }
  }
  file.once(
      Severity::note,
      why.empty() ? "a mesh is not in the model's folder: pictures leave it out" : "a mesh " + why + ": pictures leave it out",
      "the motion does not depend on it", at);
}

}  // namespace momentree::io
