#pragma once
// The interface for importers. A format is a header in importers/ with a struct of the file's name (urdf.hpp: Urdf) that has
//   static constexpr const char* name = "URDF";            // for messages
//   static constexpr const char* root = "robot";           // the root element, which identifies the format
//   static constexpr const char* endings[] = {".urdf"};    // file name endings that identify a model
//   static void read(XmlElement root, Import& import);     // fills import.model; reports in the files
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <momentree/models/import/height_grid.hpp>
#include <momentree/models/import/imported.hpp>
#include <momentree/text/files/input_file.hpp>

namespace momentree::io {

/// One model while it is read: its file and the files that it includes.
class Import {
 public:
  /// `folder`: of the file; empty: no other file is accessed. `quotes`: messages may quote lines of the file.
  Import(std::string path, std::string text, std::string folder, bool quotes);

  static constexpr std::size_t most_bodies = 1'000'000;
  ImportedModel model;

  XmlFile& file() { return *files_.front(); }
  const std::vector<std::unique_ptr<XmlFile>>& files() const { return files_; }
  /// The file that contains an element.
  XmlFile& file_of(XmlElement element);
  /// The root element of another file in the model's folder, read once; null, with a report at `at`, if it cannot be read.
  /// Including a file twice is an error, unless `again` allows it: the same root is then returned.
  XmlElement include(const std::string& name, const XmlLocation& at, XmlFile& from, bool again = false);
  /// What exists under a name in the model's folder; nothing if it is outside the folder, also by a symbolic link.
  enum class Found { nothing, file, folder };
  Found probe(const std::string& name) const;
  /// The folder of one of the files, relative to that of the model: "." or "parts/arm".
  std::string folder_of(const XmlFile& file) const;
  bool looks_at_files() const { return !folder_.empty(); }
  std::size_t errors() const;

  /// Sets a shape's mesh to a path relative to the model's folder, and its source if the file exists. `package://name/` and
  /// `model://name/` are searched there, too, then in the package of that name that contains the model: a folder above it with
  /// package.xml or model.config. A file that is not found, or only through a symbolic link out of these folders, gives a note.
  /// A path that leaves the folder gives a note and no mesh. `submesh`: the part of that name alone.
  /// The heights of a file in the model's folder: a PNG image, or as MuJoCo writes them. Null, with a warning, if there are none.
  std::shared_ptr<const HeightGrid> read_heights(const std::string& name, const XmlLocation& at, XmlFile& file) const;
  void read_mesh(const std::string& name, const XmlLocation& at, Shape& shape, XmlFile& file, const std::string& submesh = {});

 private:
  std::string folder_;
  Enclosure enclosure_;
  std::vector<std::unique_ptr<XmlFile>> files_;
  std::vector<std::filesystem::path> real_paths_;  ///< of the files, with symbolic links resolved: no file is read twice
};

/// Checks bare names of bodies and joints: names that a path, a column or a wildcard cannot contain are errors at `at`.
bool check_name(const std::string& name, const XmlLocation& at, std::string_view what, XmlFile& file);

/// A link of a model whose joints name their links (URDF, SDF).
struct NamedLink {
  std::string name;
  XmlElement element{};
};
struct NamedJoint {
  std::string name, parent, child;  ///< names of links; the child is never the ground
  bool from_ground = false;         ///< the parent is the ground
  int rows = 6;                     ///< number of DoFs that it blocks
  XmlElement element{};
  XmlLocation parent_spot{}, child_spot{};
};
struct LinkTree {
  std::vector<std::size_t> order;  ///< of links: parents first, otherwise as in the file; empty if there is an error
  std::vector<int> joint, parent;  ///< by link: its inboard joint and its parent's index, −1: none
  std::vector<std::size_t> loops;  ///< the joints that are not part of the tree
};
/// How joints that form no tree are treated.
enum class Loops { refused, closed };
/// Reports duplicate names and unknown links. More than one root is allowed. If a link has several inboard joints, or joints form
/// a cycle: `refused`: reports them, by name; `closed`: a spanning tree of spanning_joints(), whose other joints close loops.
LinkTree arrange(const std::vector<NamedLink>& links, const std::vector<NamedJoint>& joints, Loops loops, Import& import);

/// Format-independent checks of bodies, reported at their places in the file. Call it last.
void check_imported(ImportedModel& model);

}  // namespace momentree::io
