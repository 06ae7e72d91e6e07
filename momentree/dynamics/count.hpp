#pragma once
#include <momentree/math/counted.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Operations of one evaluation of q̇ and ṗ of this tree, counted on the kernels themselves, in the order of those that run many
/// worlds at once; joint forces apart. Which values the coordinates have makes no difference. Allocates.
Operations count_operations(const Tree& tree);

}  // namespace momentree
