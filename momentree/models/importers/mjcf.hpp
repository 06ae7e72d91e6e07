#pragma once
// MJCF, the model format of MuJoCo: https://mujoco.readthedocs.io/en/stable/XMLreference.html
#include <momentree/models/import/importer.hpp>

namespace momentree::io {

struct Mjcf {
  static constexpr const char* name = "MJCF";
  static constexpr const char* root = "mujoco";
  static constexpr const char* endings[] = {".mjcf"};
  static void read(XmlElement mujoco, Import& import);
};

}  // namespace momentree::io
