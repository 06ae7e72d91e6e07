#pragma once
// model.json: what a viewer needs to know beside the poses of a run: the bodies, what they look like, how they are joined.
#include <string>
#include <utility>
#include <vector>

#include <momentree/io/shape.hpp>
#include <momentree/tree/model.hpp>

namespace momentree::io {

/// The document as JSON. `shapes`: by body number; may be shorter than the model has bodies. docs/howto/read-the-results.md
/// describes it.
std::string model_json(const Model& model, const std::string& title, const std::vector<Shape>& shapes = {});

/// Lines (body axes, m) that stand for a body where it has no shape: from its inboard joint to each of its children's joints; for
/// a body without children, or whose children's joints all stand at its own, through the centre of mass to twice its distance.
/// Empty for a body whose mass lies at its joint.
std::vector<std::pair<Vec3, Vec3>> drawn_extent(const Model& model, Body body);

}  // namespace momentree::io
