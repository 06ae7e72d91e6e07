#pragma once
// Fewer triangles for the same shape.
#include <momentree/models/mesh/mesh.hpp>

namespace momentree::io {

/// Merges the points of each cell of a grid of `cells` per longest edge of the part's bounding box: the first of them stays.
/// Removes triangles that lose their area or repeat others, and points that no triangle uses.
void merge_points(MeshPart& part, double cells);

/// Collapses edges, those that change the shape least first, until at most `most` triangles are left: M. Garland, P. Heckbert,
/// "Surface simplification using quadric error metrics", SIGGRAPH 1997. Points are removed, none is moved. Edges that would turn
/// a triangle over are kept, unless no others are left. `most` is at least 56, the triangles between the corners of a box: meshes
/// that are too entangled are simplified by merge_points() instead.
void simplify(MeshPart& part, std::size_t most);

}  // namespace momentree::io
