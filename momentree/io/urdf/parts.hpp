#pragma once
// The parts of a URDF file, one reader each. Internal to the importer.
#include <string>
#include <unordered_map>

#include <momentree/io/model/importer.hpp>
#include <momentree/io/xml/fields.hpp>

namespace momentree::io::urdf {

/// Colours of the materials that the robot names, as "#rrggbb".
using Materials = std::unordered_map<std::string, std::string>;

Pose read_origin(XmlFields& fields, XmlFile& file);
/// `color` as "#rrggbb"; empty where a material has none.
std::string read_material(XmlElement material, XmlFile& file);

/// Mass, centre of mass, inertia and shapes of a link, under its own name.
ImportedBody read_link(XmlElement link, const Materials& materials, Import& import);

/// A joint and what it says of itself; ends are still names. Small: a file has many, and bodies are made only in the end.
struct Joint {
  NamedJoint ends;
  Kind kind = Kind::weld;
  Vec3 axis{0, 0, 1};
  Pose at{};
  Quat turn{};  ///< of the joint's frame in that of the child
  double damping = 0, friction = 0, lower = 0, upper = 0;
  XmlElement limit{};  ///< that of `lower` and `upper`, where there is one
  XmlElement mimic{};
};
Joint read_joint(XmlElement joint, XmlFile& file);

}  // namespace momentree::io::urdf
