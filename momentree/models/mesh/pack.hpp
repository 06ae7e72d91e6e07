#pragma once
// The meshes of a world for pages: simplified, with positions of 16 bits.
#include <memory>
#include <string>
#include <vector>

#include <momentree/models/mesh/source.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

using MeshSources = std::vector<std::shared_ptr<const MeshSource>>;

struct PackedMeshes {
  /// A JSON list with one entry per source, null for a mesh that cannot be read; docs/howto/use-the-results.md describes it.
  /// Empty if there are no sources.
  std::string json{};
  std::vector<Diagnostic> warnings{};  ///< of meshes that cannot be read
};

/// `most`: triangles of all meshes together; larger meshes are simplified first, down to the size at which the sum fits.
PackedMeshes pack_meshes(const MeshSources& sources, std::size_t most = 60'000);

/// The same as the document meshes.json, for the sources of mesh_sources().
PackedMeshes meshes_json(const MeshSources& sources);

}  // namespace momentree::io
