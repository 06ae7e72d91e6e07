#pragma once
// Meshes that are not convex, as convex parts.
#include <memory>
#include <string>
#include <vector>

#include <momentree/models/mesh/mesh.hpp>

namespace momentree::io {

/// The least concavity that split_mesh() takes, and that of meshes whose file asks for a decomposition without one.
inline constexpr double least_split = 0.01, usual_split = 0.05;

struct SplitMesh {
  std::vector<std::vector<Vec3>> parts{};  ///< the corners of each
  std::string problem{}, hint{};           ///< why there are none
};

/// Convex parts of a closed mesh whose triangles face outwards, or all inwards. Shells that are convex are parts as they are;
/// others are split by CoACD (Wei et al. 2022), loaded from the path in the environment variable MOMENTREE_COACD, or else as the
/// loader finds lib_coacd.so. `concavity`, up to 1: parts reach outside of the mesh by about half of it, relative to the mesh's
/// largest extent. The same mesh is split once in a process, and always in the same way.
std::shared_ptr<const SplitMesh> split_mesh(const MeshPart& mesh, double concavity);

}  // namespace momentree::io
