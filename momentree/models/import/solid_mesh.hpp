#pragma once
// Meshes as solids: what is inside of them, and their mass.
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <momentree/math/mass_properties.hpp>
#include <momentree/models/import/shape.hpp>
#include <momentree/models/mesh/mesh.hpp>

namespace momentree::io {

using ReportOnShape = std::function<void(const std::string& what, const std::string& hint)>;

/// A mesh in its own axes, scaled. Nothing, with a report, if it cannot be read.
std::optional<MeshPart> mesh_of(const Shape& shape, const std::string& name, const ReportOnShape& refuse);
std::vector<Vec3> moved(std::vector<Vec3> points, const Pose& at);
/// True if each edge belongs to an even number of triangles. Corners of different triangles are the same if they coincide.
bool is_closed(const std::vector<Vec3>& points, const std::vector<std::array<std::uint32_t, 3>>& triangles);

/// Mass and inertia of a shape of uniform density (kg/m³), without its further ones. Nothing, with a report, for planes, and for
/// meshes that cannot be read or are not closed.
std::optional<MassProperties> mass_of(const Shape& shape, double density, const ReportOnShape& refuse);

}  // namespace momentree::io
