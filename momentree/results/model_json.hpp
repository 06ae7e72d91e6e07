#pragma once
// model.json: what a viewer needs in addition to the poses of a run: the bodies, their shapes, and the joints between them.
#include <memory>
#include <string>
#include <vector>

#include <momentree/models/import/shape.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::io {

/// The document as JSON: the world at the start of a run. `shapes`: by body number; may be shorter than the number of bodies.
/// docs/howto/use-the-results.md describes the format.
///
/// Its `extent` has lines (body axes, m) that represent a body: from its inboard joint to each of its children's joints; for a
/// body without children, or whose children's joints are all at its own joint, to the centre of mass, extended to twice that
/// distance if the body has no shape. A body whose mass is at its joint has no lines.
std::string model_json(const World& world, const std::string& title, const std::vector<Shape>& shapes = {});

/// The different meshes of the shapes, in the order of their numbers in the document's member `mesh` of shapes.
std::vector<std::shared_ptr<const MeshSource>> mesh_sources(const std::vector<Shape>& shapes);

}  // namespace momentree::io
