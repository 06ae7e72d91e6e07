#pragma once
// Where the mesh of a shape comes from.
#include <string>

#include <momentree/base/value.hpp>
#include <momentree/models/mesh/mesh.hpp>

namespace momentree::io {

/// A mesh that a scenario or a model file refers to. It is read only for what shows it.
struct MeshSource {
  std::string path{};     ///< the file, as it can be opened; empty: `inside` is the mesh
  std::string submesh{};  ///< the part of that name alone; empty: the whole mesh
  std::string colour{};   ///< "#rrggbb" of parts without a colour of their own; empty: none is given
  MeshPart inside{};      ///< points and triangles that the model file itself contains
  std::string file{};     ///< the file that refers to it, and
  Place place{};          ///< where

  /// The same for sources of the same mesh.
  std::string key() const {
    if (!path.empty()) return path + '\n' + submesh + '\n' + colour;
    return file + ':' + std::to_string(place.line) + ':' + std::to_string(place.column);
  }
};

}  // namespace momentree::io
