#pragma once
// Elements between joints that end in a run. Internal to worlds.
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Ends the elements of a joint on their other joints, once that joint broke or became another.
void end_elements(Tree& tree, JointId joint);

}  // namespace momentree
