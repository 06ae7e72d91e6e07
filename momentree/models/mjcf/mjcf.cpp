#include <momentree/models/importers/mjcf.hpp>

#include <momentree/base/error.hpp>
#include <momentree/models/mjcf/parts.hpp>

namespace momentree::io {

namespace {

using namespace mjcf;

void read_option(XmlElement option, Reading& reading) {
  XmlFile& file = reading.file_of(option);
  if (option.find("gravity")) {
    XmlFields fields(option, file);
    if (const auto gravity = fields.vec3("gravity")) reading.import.model.gravity = *gravity;
  }
  for (const char* medium : {"density", "viscosity"}) {
    const auto i = option.find(medium);
    if (i && option.attribute(*i) != "0")
      file.once(Severity::warning, "the medium is ignored: " + std::string(medium), "a [[force]] can have drag", {option, *i});
  }
}

void read_assets(XmlElement asset, Reading& reading) {
  for (const XmlElement material : children_of(asset, reading)) {
    if (material.name() == "mesh") read_mesh_asset(material, reading);
    if (material.name() == "hfield") read_field_asset(material, reading);
    const auto name = material.find("name"), rgba = material.find("rgba");
    if (material.name() != "material" || !name || !rgba) continue;
    const auto levels = read_numbers(material.attribute(*rgba), 4, 4, {material, *rgba}, "rgba", reading.file_of(material));
    if (levels) reading.colours.emplace(std::string(material.attribute(*name)), colour_text(*levels));
  }
}

void leave_out(XmlElement section, const std::string& why, Reading& reading) {
  for (const XmlElement each : children_of(section, reading))
    reading.file_of(each).once(Severity::note, each.tag() + " in " + section.tag() + " is ignored", why, {each});
}

void scale_mass(ImportedModel& model, double total) {
  double sum = 0;
  for (const ImportedBody& body : model.bodies) sum += body.spec.mass;
  if (!(sum > 0)) return;
  const double f = total / sum;
  for (ImportedBody& body : model.bodies) {
    Sym3& i = body.spec.inertia;
    body.spec.mass *= f;
    i = {f * i.xx, f * i.yy, f * i.zz, f * i.xy, f * i.xz, f * i.yz};
  }
}

// Unnamed joints get their body's name, which may be that of another joint.
void name_joints(ImportedModel& model, Reading& reading) {
  for (ImportedBody& body : model.bodies) {
    const auto named = reading.joint_names.find(body.spec.joint_name);
    if (named == reading.joint_names.end() || named->second == body.spots.joint) continue;
    body.spec.joint_name += body.spec.parent == ground ? "~root" : "~joint";
  }
}

}  // namespace

void Mjcf::read(XmlElement mujoco, Import& import) {
  Reading reading{import};
  import.model.friction_of_two = FrictionOfTwo::larger;
  if (const auto title = mujoco.find("model")) import.model.title = mujoco.attribute(*title);
  const std::vector<XmlElement> sections = children_of(mujoco, reading);
  // Sections that others refer to are read first, wherever they are.
  for (const XmlElement each : sections) {
    if (each.name() == "compiler") read_compiler(each, reading);
    if (each.name() == "default") read_defaults(each, "", reading);
    if (each.name() == "option") read_option(each, reading);
  }
  for (const XmlElement each : sections)
    if (each.name() == "asset") read_assets(each, reading);
  bool has_world = false;
  std::vector<XmlElement> tendons, equalities, contacts;
  for (const XmlElement each : sections)
    if (each.name() == "contact") find_pairs(contacts.emplace_back(each), reading);
  for (const XmlElement each : sections) {
    const std::string_view tag = each.name();
    XmlFile& file = reading.file_of(each);
    if (tag == "worldbody") {
      has_world = true;
      read_world(each, reading);
      if (file.enough()) return;
    } else if (tag == "equality") {
      equalities.push_back(each);
    } else if (tag == "tendon") {
      tendons.push_back(each);
    } else if (tag == "actuator" || tag == "sensor") {
      leave_out(each, tag == "actuator" ? "an event's set = { joint, drive } drives a joint" : "", reading);
    } else if (tag == "deformable") {
      file.error({each}, each.tag() + " is not supported: bodies are rigid", "leave it out");
    } else if (tag == "keyframe" || tag == "custom" || tag == "extension" || tag == "skin") {
      file.once(Severity::note, each.tag() + " is ignored", "", {each});
    } else if (tag != "compiler" && tag != "default" && tag != "option" && tag != "contact" && tag != "asset" && tag != "size" &&
               tag != "visual" && tag != "statistic") {
      file.once(Severity::note, each.tag() + " in <mujoco> is ignored",
                did_you_mean(tag, {"worldbody", "default", "compiler", "option"}), {each});
    }
  }
  if (!has_world || (import.model.bodies.empty() && import.errors() == 0))
    return reading.file_of(mujoco).error({mujoco}, "the model has no <body> in a <worldbody>",
                                         "for example <worldbody><body><geom size=\"1\"/></body></worldbody>");
  if (reading.compiler.settotalmass > 0) scale_mass(import.model, reading.compiler.settotalmass);
  name_joints(import.model, reading);
  for (const XmlElement each : contacts) read_contacts(each, reading);
  for (const XmlElement each : tendons) read_tendons(each, reading);
  if (!equalities.empty()) read_equalities(equalities, reading);
}

}  // namespace momentree::io
