#pragma once
// URDF, the Unified Robot Description Format of ROS: http://wiki.ros.org/urdf/XML
#include <momentree/models/import/importer.hpp>

namespace momentree::io {

struct Urdf {
  static constexpr const char* name = "URDF";
  static constexpr const char* root = "robot";
  static constexpr const char* endings[] = {".urdf"};
  static void read(XmlElement robot, Import& import);
};

}  // namespace momentree::io
