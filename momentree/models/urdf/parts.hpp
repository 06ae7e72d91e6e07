#pragma once
// The parts of a URDF file, one reader each. Internal to the importer.
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <momentree/models/import/importer.hpp>
#include <momentree/models/xml/fields.hpp>

namespace momentree::io::urdf {

/// Colours of the robot's named materials, as "#rrggbb".
using Materials = std::unordered_map<std::string, std::string>;

/// A name as it is used here: characters that a path, a column or a wildcard cannot contain become '_', and the name of the
/// ground gets one. Every name of a file passes through it, also where it refers to a link or a joint.
std::string usable_name(std::string name);
/// The usable `name` of a link or joint; a changed one is a warning, one that is still invalid an error.
std::string read_name(XmlFields& fields, std::string_view what, XmlFile& file);

Pose read_origin(XmlFields& fields, XmlFile& file);
/// `color` as "#rrggbb"; empty if the material has none.
std::string read_material(XmlElement material, XmlFile& file);

/// Reads mass, centre of mass, inertia and shapes of a link, under its own name.
ImportedBody read_link(XmlElement link, const Materials& materials, Import& import);

/// A joint as read; its links are still names. It is small, since a file has many; bodies are created only at the end.
struct Joint {
  NamedJoint ends;
  Kind kind = Kind::weld;
  Vec3 axis{0, 0, 1};
  Pose at{};
  Quat turn{};  ///< rotation of the joint's frame in the child's frame
  double damping = 0, friction = 0, lower = 0, upper = 0;
  XmlElement limit{};  ///< the element with `lower` and `upper`, if there is one
  XmlElement mimic{};
};
Joint read_joint(XmlElement joint, XmlFile& file);

/// Reads the friction of links from <gazebo> elements: mu1, the first of two coefficients.
void read_gazebo(const std::vector<XmlElement>& elements, ImportedModel& model, XmlFile& file);

}  // namespace momentree::io::urdf
