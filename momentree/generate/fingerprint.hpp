#pragma once
#include <span>
#include <string>

#include <momentree/tree/state.hpp>

namespace momentree {

/// All that an evaluation in these variables, without forces, reads of a tree, as bytes: trees with equal fingerprints run the
/// same operations on the same constants. `rows`: the chosen rows of closed loops.
std::string fingerprint(const Tree& tree, Variables variables = Variables::momenta, std::span<const int> rows = {});

}  // namespace momentree
