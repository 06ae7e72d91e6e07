#pragma once
// The shapes of colliders, for pictures of bodies that have no others.
#include <vector>

#include <momentree/contact/shapes/solid.hpp>
#include <momentree/model/model.hpp>
#include <momentree/models/import/shape.hpp>
#include <momentree/models/mesh/mesh.hpp>

namespace momentree::io {

/// The shape of a solid; none for a hull.
Shape solid_shape(const contact::Solid& solid);
/// Triangles of a polyhedron; of a rounded one those between some of its points.
MeshPart surface_of(const contact::Solid& solid);

/// A shape in the world, and its triangles if it is a mesh.
struct GroundShape {
  Shape shape{};
  MeshPart mesh{};
};
/// What the ground has besides planes.
std::vector<GroundShape> ground_shapes(const Model& model);

/// By body, its shape, or those of its colliders if it has none but meshes that do not exist. Hulls of meshes are not drawn.
/// `shapes`: by body; may be shorter than the list of bodies.
std::vector<Shape> drawn_shapes(const Model& model, const std::vector<Shape>& shapes);

}  // namespace momentree::io
