#pragma once
// Couplings of a state document. Internal to its reader.
#include <momentree/scenario/keys/fields.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::io {

/// Reads `couplings`, a list in the order of the model, and adds those that have ended to the forest.
void read_coupling_states(const Value& list, const Model& model, Forest& forest, Diagnostics& out);

}  // namespace momentree::io
