#pragma once
// The momenta of a joint that has just become another, or has just been made.
#include <momentree/math/spatial.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// (28): p = E′ᵀ Pb of b's joint as the tree has it now, at coordinates q, none for locked freedoms; Pb in the user's frame of b.
void new_joint_momenta(const Tree& tree, int b, const double* q, const Force<double>& Pb, double* p) noexcept;

}  // namespace momentree
