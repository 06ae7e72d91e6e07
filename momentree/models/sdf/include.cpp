// <include>: a model from another file in the folder, unchanged except for its name, pose and static flag.
#include <filesystem>

#include <momentree/models/sdf/parts.hpp>

namespace momentree::io::sdf {

namespace {

namespace fs = std::filesystem;

// The path without model:// and the like; nothing, with a report, if it is not a local file.
std::optional<std::string> path_of(const std::string& uri, const XmlLocation& location, XmlFile& file) {
  const std::size_t colon = uri.find("://");
  if (colon == std::string::npos) return uri;
  const std::string scheme = uri.substr(0, colon);
  if (scheme == "model" || scheme == "package" || scheme == "file") return uri.substr(colon + 3);
  file.error(location, "include: " + in_quotes(uri) + " is not fetched", "copy it into the model's folder and name it there");
  return {};
}

// The file of a model's folder: the folder's description lists the files and their SDF versions.
std::string file_of_folder(const std::string& folder, const XmlLocation& location, Reading& reading, XmlFile& file) {
  const std::string config = (fs::path(folder) / "model.config").generic_string();
  std::string best = "model.sdf";
  if (reading.import.probe(config) != Import::Found::file) return (fs::path(folder) / best).generic_string();
  const XmlElement root = reading.import.include(config, location, file, true);
  int newest = -1;
  if (root)
    for (const XmlElement each : root.children()) {
      if (each.name() != "sdf" || each.text().empty()) continue;
      const auto version = each.find("version");
      const std::string_view text = version ? each.attribute(*version) : "";
      int minor = 0;
      for (const char c : text.substr(text.find('.') == std::string_view::npos ? text.size() : text.find('.') + 1, 3))
        minor = c >= '0' && c <= '9' ? 10 * minor + (c - '0') : minor;
      if (minor > newest) newest = minor, best = each.text();
    }
  return (fs::path(folder) / best).generic_string();
}

// Searched next to the including file, then in the model's folder.
XmlElement open(const std::string& uri, const XmlLocation& location, Reading& reading, XmlFile& file) {
  Import& import = reading.import;
  const auto path = path_of(uri, location, file);
  if (!path) return {};
  std::string found = *path;
  if (import.looks_at_files() && !found.empty()) {
    const std::string beside = (fs::path(import.folder_of(file)) / *path).lexically_normal().generic_string();
    if (fs::path(*path).is_relative() && import.probe(beside) != Import::Found::nothing) found = beside;
    if (import.probe(found) == Import::Found::folder) found = file_of_folder(found, location, reading, file);
  }
  return import.include(found, location, file, true);
}

}  // namespace

std::optional<NestedPart> read_include(XmlElement element, const ModelPart& into, Reading& reading, XmlFile& file, int depth) {
  Texts texts(element, file);
  XmlFields& fields = texts.fields;
  NestedPart nested;
  nested.element = element;
  nested.merged = fields.boolean("merge").value_or(false);
  const XmlLocation merge = fields.location("merge");
  const auto uri = texts.string("uri");
  const XmlLocation uri_spot = texts.location();
  if (!uri) fields.require_child("uri", "for example <uri>arm.sdf</uri>");
  const auto name = texts.string("name");
  const XmlLocation name_spot = texts.location();
  const auto is_static = texts.boolean("static");
  const auto placement = texts.string("placement_frame");
  nested.placement_spot = texts.location();
  const bool placed = static_cast<bool>(fields.child("pose"));
  nested.pose = read_pose(fields, into.version, file);
  fields.leave_out({"plugin"}, "it belongs to another program");
  for (const XmlElement child : element.children())
    if (child.name() == "experimental:params")
      file.error({child}, "<experimental:params> changes the included model, which is not supported", "change a copy of it");
  fields.finish();
  if (!uri) return {};
  if (nested.merged && into.is_world) file.error(merge, "merge: a world cannot merge the parts of a model", "leave merge out");
  if (placement && !placed) file.error(nested.placement_spot, "<placement_frame> has no effect without <pose>", "give a <pose>");

  const XmlElement root = open(*uri, uri_spot, reading, file);
  if (!root) return {};
  XmlFile& other = reading.import.file_of(root);
  const auto known = reading.read.find(root.document());
  if (known != reading.read.end()) {
    nested.model = known->second;
  } else {
    reading.open.push_back(&other);
    for (std::size_t i = 0; i + 1 < reading.open.size(); ++i) {
      if (reading.open[i] != &other) continue;
      std::string circle;
      for (std::size_t k = i; k < reading.open.size(); ++k)
        circle += (k == i ? "" : " – ") + in_quotes(fs::path(reading.open[k]->path()).filename().string());
      file.error(uri_spot, "include: files include each other in a cycle: " + circle, "leave one of them out");
      reading.open.pop_back();
      return {};
    }
    if (root.name() != "sdf")
      other.error({root}, "an SDF can include only SDF, not " + in_quotes(root.tag()), "convert it (gz sdf -p)");
    else
      nested.model = read_root(root, reading, other, true, depth);
    reading.open.pop_back();
    reading.read.emplace(root.document(), nested.model);
  }
  if (!nested.model) return {};
  const ModelPart& model = *nested.model;
  nested.name = name && !name->empty() ? *name : model.name;
  if (name && name->find("::") != std::string::npos)
    file.error(name_spot, "name: '::' separates the names of a model and its parts");
  nested.is_static = is_static.value_or(model.is_static);
  nested.placement_frame = placement.value_or(model.placement_frame);
  if (!placement) nested.placement_spot = model.placement_spot;
  if (!placed) nested.pose = model.pose;
  return nested;
}

}  // namespace momentree::io::sdf
