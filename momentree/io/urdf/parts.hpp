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

/// A joint and what it says of itself; ends are still names.
struct Joint {
  NamedJoint ends;
  BodySpec spec;  ///< at, child_at, joint
  JointLimits limits{};
  XmlElement limit{}, mimic{};
};
Joint read_joint(XmlElement joint, XmlFile& file);

}  // namespace momentree::io::urdf
