#pragma once
// How bodies of a tree answer wrenches, one at a time: for those who walk through it instead of solving for all of it.
#include <array>

#include <momentree/dynamics/evaluate.hpp>

namespace momentree {

/// Of a body, in its kernel frame, by components of a unit wrench on it (l, h), or of a unit motion (v, w) of its parent.
struct BodyResponse {
  std::array<Force<double>, 6> carried;        ///< by wrench: the wrench on the parent, in its kernel frame (51), (45)
  std::array<Motion<double>, 6> moves;         ///< by wrench: the motion of the body while the parent rests
  std::array<std::array<double, 6>, 6> own;    ///< by wrench: the velocities of its joint while the parent rests
  std::array<std::array<double, 6>, 6> given;  ///< by motion of the parent: the velocities of its joint (47)
};

/// Those of the bodies at places begin … end − 1 of the tree's order. Requires the factors of an evaluation at q.
void find_body_responses(const Tree& tree, const double* q, const Workspace<double>& workspace, int begin, int end,
                         BodyResponse* responses) noexcept;

}  // namespace momentree
