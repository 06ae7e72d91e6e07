#pragma once
// The parts of a URDF file, one reader each. Internal to the importer.
#include <string>
#include <unordered_map>

#include <momentree/io/model/importer.hpp>
#include <momentree/io/xml/fields.hpp>

namespace momentree::io::urdf {

/// Colours of the robot's named materials, as "#rrggbb".
using Materials = std::unordered_map<std::string, std::string>;

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

}  // namespace momentree::io::urdf
