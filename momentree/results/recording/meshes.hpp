#pragma once
// meshes.json of a result, unpacked (docs/howto/use-the-results.md describes it).
#include <filesystem>
#include <vector>

#include <momentree/models/mesh/mesh.hpp>

namespace momentree::io {

/// A mesh: `count` parts from `first` on, of all parts.
struct MeshParts {
  std::size_t first = 0, count = 0;
};

/// The meshes by number, none if the file does not exist; appends their parts to `parts`. Throws Error, with the file, if it is
/// damaged.
std::vector<MeshParts> read_meshes(const std::filesystem::path& file, std::vector<MeshPart>& parts);

}  // namespace momentree::io
