#pragma once
// Mass and inertia of bodies of uniform density.
#include <array>
#include <cstdint>
#include <span>

#include <momentree/contact/primitive.hpp>
#include <momentree/math/mass_properties.hpp>

namespace momentree {

/// Of a shape; `density`: kg/m³.
MassProperties mass_properties(const contact::Primitive& shape, const Pose& at, double density);
/// Of what closed triangles enclose that all face outwards, or all inwards.
MassProperties mass_properties(std::span<const Vec3> points, std::span<const std::array<std::uint32_t, 3>> triangles,
                               double density);
/// Of several together; zero if they have no mass.
MassProperties sum_of(std::span<const MassProperties> parts);

}  // namespace momentree
