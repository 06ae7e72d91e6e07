#pragma once
// Mesh files as triangles. The format follows from the file name's ending; nothing in a file is trusted: counts are compared with
// the size of the file, indices with the number of points, and numbers must be finite.
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include <momentree/models/mesh/mesh.hpp>

namespace momentree::io {

/// Opens a file that a mesh file names (materials, buffers), relative to the mesh's folder; nothing if it must not or cannot be
/// read.
using CompanionFiles = std::function<std::optional<std::string>(const std::string& name)>;

inline constexpr std::size_t largest_mesh_file = 256u << 20;   ///< bytes
inline constexpr std::size_t most_mesh_triangles = 4'000'000;  ///< of one file

/// True if the name ends as that of a mesh that can be read: .stl, .obj, .dae, .gltf, .glb, in any case.
bool is_mesh_name(std::string_view name);

/// The triangles of a mesh file's content. `name`: its ending gives the format. `submesh`: the part of that name alone, if the
/// format names its parts (OBJ, Collada, glTF); empty: all. Throws Error, without a place, if the content is wrong or too large.
Mesh read_mesh_text(std::string_view content, const std::string& name, const std::string& submesh = {},
                    const CompanionFiles& companions = {});

/// The same from a file; its companions are in its folder or below it, with symbolic links resolved.
Mesh read_mesh_file(const std::string& path, const std::string& submesh = {});

}  // namespace momentree::io
