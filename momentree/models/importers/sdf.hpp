#pragma once
// SDF, the Simulation Description Format of Gazebo: http://sdformat.org/spec
#include <momentree/models/import/importer.hpp>

namespace momentree::io {

struct Sdf {
  static constexpr const char* name = "SDF";
  static constexpr const char* root = "sdf";
  static constexpr const char* endings[] = {".sdf", ".world"};
  static void read(XmlElement sdf, Import& import);
};

}  // namespace momentree::io
