#pragma once
#include <string>

#include <momentree/tree/state.hpp>

namespace momentree {

/// All that an evaluation in these variables, without forces, reads of a tree, as bytes: trees with equal fingerprints run the
/// same operations on the same constants.
std::string fingerprint(const Tree& tree, Variables variables = Variables::momenta);

}  // namespace momentree
