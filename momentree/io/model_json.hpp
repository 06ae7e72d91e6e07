#pragma once
// model.json: what a viewer needs to know beside the poses of a run: the bodies, what they look like, how they are joined.
#include <string>
#include <vector>

#include <momentree/io/shape.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree::io {

/// The document as JSON: the world as a run begins with it. `shapes`: by body number; may be shorter than the model has bodies.
/// docs/howto/use-the-results.md describes it.
///
/// Its `extent` has lines (body axes, m) that stand for a body: from its inboard joint to each of its children's joints; for a
/// body without children, or whose children's joints all stand at its own, to the centre of mass, and beyond it to twice its
/// distance where there is no shape. None for a body whose mass lies at its joint.
std::string model_json(const World& world, const std::string& title, const std::vector<Shape>& shapes = {});

}  // namespace momentree::io
