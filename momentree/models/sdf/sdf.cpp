#include <momentree/models/importers/sdf.hpp>

#include <charconv>

#include <momentree/base/error.hpp>
#include <momentree/models/sdf/parts.hpp>

namespace momentree::io {

namespace sdf {

namespace {

constexpr int oldest = 4, newest = 10;

// For an invalid version, the newest: the rest of the file is checked anyway.
Version read_version(XmlFields& fields, XmlFile& file) {
  const std::string known = "1." + std::to_string(oldest) + " to 1." + std::to_string(newest);
  if (!fields.require("version", "versions " + known + " are read, for example version=\"1.9\"")) return {newest};
  const std::string text = fields.string("version").value_or("");
  int minor = -1;
  if (text.starts_with("1.")) {
    const auto [end, code] = std::from_chars(text.data() + 2, text.data() + text.size(), minor);
    if (code != std::errc{} || end != text.data() + text.size()) minor = -1;
  }
  if (minor < 0) {
    file.error(fields.location("version"), "version: expected a version of SDF, found " + in_quotes(text),
               "versions " + known + " are read");
  } else if (minor < oldest) {
    file.error(fields.location("version"), "version: SDF " + text + " is too old: versions " + known + " are read",
               "gz sdf -p writes a newer one");
  } else if (minor > newest) {
    file.warning(fields.location("version"), "version: SDF " + text + " is read as 1." + std::to_string(newest),
                 "newer elements are left out with a note");
    return {newest};
  } else {
    return {minor};
  }
  return {newest};
}

}  // namespace

std::shared_ptr<const ModelPart> read_root(XmlElement root, Reading& reading, XmlFile& file, bool included, int depth) {
  XmlFields fields(root, file);
  const Version version = read_version(fields, file);
  const auto models = fields.children("model"), worlds = fields.children("world");
  fields.leave_out({"light", "actor"}, "it belongs to another program");
  fields.finish();
  const std::size_t count = models.size() + (included ? 0 : worlds.size());
  if (count == 0) {
    file.error({root}, included ? "the included file has no <model>" : "the file has no <model> and no <world>",
               worlds.empty() ? "for example <model name=\"arm\">, with its links" : "a world cannot be included");
    return nullptr;
  }
  if (count > 1) {
    const XmlElement first = models.empty() ? worlds[0] : models[0];
    const XmlElement second = models.empty() ? worlds[1] : models.size() > 1 ? models[1] : worlds[0];
    file.error({second}, "a second " + second.tag() + " in addition to that on " + file.line_of(first),
               included ? "an included file has one model" : "put models into one <world>");
    return nullptr;
  }
  return read_model(models.empty() ? worlds[0] : models[0], version, reading, file, depth);
}

}  // namespace sdf

void Sdf::read(XmlElement outermost_element, Import& import) {
  sdf::Reading reading{import};
  reading.open.push_back(&import.file());
  const auto outermost = sdf::read_root(outermost_element, reading, import.file(), false, 0);
  if (!outermost || import.errors() > 0) return;
  import.model.title = outermost->name;
  import.model.gravity = reading.gravity;
  sdf::build(*outermost, import);
}

}  // namespace momentree::io
