// What <gazebo> elements say of links: the friction of their contacts.
#include <unordered_map>

#include <momentree/models/urdf/parts.hpp>

namespace momentree::io::urdf {

namespace {

// A coefficient, as text or as an attribute.
std::optional<double> read_coefficient(XmlElement gazebo, std::string_view name, XmlFile& file) {
  std::optional<double> value;
  for (const XmlElement each : gazebo.children()) {
    if (each.name() != name) continue;
    XmlLocation at{each, XmlLocation::no_attribute, true};
    std::optional<std::vector<double>> numbers;
    if (const auto given = each.find("value"))
      at = {each, *given}, numbers = read_numbers(each.attribute(*given), 1, 1, at, name, file);
    else
      numbers = read_numbers(each.text(), 1, 1, at, name, file);
    if (!numbers) continue;
    if (!((*numbers)[0] >= 0)) {
      file.error(at, std::string(name) + ": must not be negative");
      continue;
    }
    value = (*numbers)[0];
  }
  return value;
}

bool has_friction(XmlElement gazebo) {
  for (const XmlElement each : gazebo.children())
    if (each.name() == "mu1" || each.name() == "mu2") return true;
  return false;
}

}  // namespace

void read_gazebo(const std::vector<XmlElement>& elements, ImportedModel& model, XmlFile& file) {
  std::unordered_map<std::string_view, ImportedBody*> bodies;
  for (ImportedBody& body : model.bodies) bodies.emplace(body.spec.name, &body);
  for (const XmlElement gazebo : elements) {
    const auto reference = gazebo.find("reference");
    if (!reference || !has_friction(gazebo)) {
      file.once(Severity::note, "<gazebo> is ignored", "it belongs to another program", {gazebo});
      continue;
    }
    const std::optional<double> first = read_coefficient(gazebo, "mu1", file), second = read_coefficient(gazebo, "mu2", file);
    const std::string name = usable_name(std::string(gazebo.attribute(*reference)));
    const auto found = bodies.find(name);
    if (found == bodies.end()) {
      file.warning({gazebo, *reference}, "<gazebo>: there is no link " + in_quotes(name) + ": its friction is ignored", "");
      continue;
    }
    if (first) found->second->friction = *first;
    if (second && *second != first.value_or(1)) file.once(Severity::warning, different_friction, friction_hint, {gazebo});
  }
}

}  // namespace momentree::io::urdf
