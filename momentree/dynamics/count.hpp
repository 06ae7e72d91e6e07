#pragma once
#include <momentree/math/counted.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Operations of one evaluation of q̇ and ṗ of this tree, without joint forces, counted by running the kernels themselves, in the
/// order that is used for many worlds at once. The result does not depend on the coordinates. Allocates.
Operations count_operations(const Tree& tree);

}  // namespace momentree
