#pragma once
// Meshes and collision elements for tests of what touches.
#include <fstream>
#include <string>

#include <momentree/scenario/scenario.hpp>

namespace momentree::io::test {

inline void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

inline std::string warnings(const ReadResult& result) {
  std::string text;
  for (const Diagnostic& each : result.diagnostics)
    if (each.severity == Severity::warning) text += each.message() + "\n";
  return text;
}

// An OBJ file of a box from −half to half, with every corner twice.
inline std::string box_mesh(const Vec3& half) {
  std::string text;
  for (int copy = 0; copy < 2; ++copy)
    for (int i = 0; i < 8; ++i)
      text += "v " + std::to_string((i & 1) != 0 ? half.x : -half.x) + " " + std::to_string((i & 2) != 0 ? half.y : -half.y) +
              " " + std::to_string((i & 4) != 0 ? half.z : -half.z) + "\n";
  text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\n";
  return text + "f 2 4 8 6\n";
}

inline const std::string a_floor = "format = 1\n[world]\nfloor = true\n";
inline const std::string a_mesh_above =
    "[[mechanism]]\nname = \"m\"\nroot = \"free\"\npose = { xyz = [0, 0, 1] }\n[[mechanism.body]]\nname = \"m\"\nmass = 1\n"
    "inertia = [0.1, 0.1, 0.1]\n";

inline std::string link(const std::string& name, const std::string& collision) {
  return "<link name='" + name + "'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>" + collision +
         "</link>\n";
}
inline std::string collision(const std::string& geometry, const std::string& at = "0 0 0") {
  return "<collision><origin xyz='" + at + "'/><geometry>" + geometry + "</geometry></collision>";
}

}  // namespace momentree::io::test
