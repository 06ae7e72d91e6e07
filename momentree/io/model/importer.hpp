#pragma once
// What an importer works with. A format is a header in importers/ with a struct of the file's name (urdf.hpp: Urdf) that has
//   static constexpr const char* name = "URDF";            // for messages
//   static constexpr const char* root = "robot";           // the root element, by which a file is known
//   static constexpr const char* endings[] = {".urdf"};    // by which a path is taken for a model
//   static void read(XmlElement root, Import& import);     // fills import.model; reports in the files
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <momentree/io/input_file.hpp>
#include <momentree/io/model/imported.hpp>

namespace momentree::io {

/// One model while it is read: its file and those that it includes.
class Import {
 public:
  /// `folder`: of the file; empty: no other file is looked for. `quotes`: messages show lines of the file.
  Import(std::string path, std::string text, std::string folder, bool quotes);

  static constexpr std::size_t most_bodies = 1'000'000;
  ImportedModel model;

  XmlFile& file() { return *files_.front(); }
  const std::vector<std::unique_ptr<XmlFile>>& files() const { return files_; }
  /// The file that an element stands in.
  XmlFile& file_of(XmlElement element);
  /// The root of another file in the model's folder, read once; none, with a report at `at`, where it can't be. A second time is
  /// an error, or the same root `again`.
  XmlElement include(const std::string& name, const XmlLocation& at, XmlFile& from, bool again = false);
  /// What stands under a name in the model's folder; nothing where it is not in it, or where a symbolic link leads out of it.
  enum class Found { nothing, file, folder };
  Found look(const std::string& name) const;
  /// The folder of one of the files, as seen from the model's: "." or "parts/arm".
  std::string folder_of(const XmlFile& file) const;
  bool looks_at_files() const { return !folder_.empty(); }
  std::size_t errors() const;

  /// A shape's mesh as a path in the model's folder. `package://name/` and the like are looked for there too; what is not found,
  /// or only by a symbolic link out of the folder, is a warning, and a path that leaves the folder an error.
  void read_mesh(const std::string& name, const XmlLocation& at, Shape& shape, XmlFile& file);

 private:
  std::string folder_;
  Enclosure enclosure_;
  std::vector<std::unique_ptr<XmlFile>> files_;
  std::vector<std::filesystem::path> real_paths_;  ///< of the files, without symbolic links: none is read twice
};

/// Bare names of bodies and joints: what a path, a column or a wildcard could not carry is refused at `at`.
bool check_name(const std::string& name, const XmlLocation& at, std::string_view what, XmlFile& file);

/// A link of a model that names its joints' ends (URDF, SDF), and its joint once it is known.
struct NamedLink {
  std::string name;
  XmlElement element{};
};
struct NamedJoint {
  std::string name, parent, child;  ///< names of links; the child is never the ground
  bool from_ground = false;         ///< the parent is the ground
  XmlElement element{};
  XmlLocation parent_spot{}, child_spot{};
};
struct LinkTree {
  std::vector<std::size_t> order;  ///< of links, parents first, else as in the file; empty where something is wrong
  std::vector<int> joint, parent;  ///< by link: its inboard joint and its parent's number, −1: none
};
/// Reports duplicate names, ends that are unknown, second parents (closed loops by name) and circles. More than one root is fine.
LinkTree arrange(const std::vector<NamedLink>& links, const std::vector<NamedJoint>& joints, Import& import);

/// What is wrong with bodies whatever their format: at their places in the file. To be called last.
void check_imported(ImportedModel& model);

}  // namespace momentree::io
