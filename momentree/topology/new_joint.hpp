#pragma once
// What a joint must be that a change makes, and its momenta.
#include <momentree/math/spatial.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Stops the program where a change would make a joint that can't be.
void require_joint(const Joint& joint, const Values& q) noexcept;

/// (28): p = E′ᵀ Pb of b's joint as the tree has it now, at coordinates q, none for locked freedoms; Pb in the user's frame of b.
void new_joint_momenta(const Tree& tree, int b, const double* q, const Force<double>& Pb, double* p) noexcept;

}  // namespace momentree
