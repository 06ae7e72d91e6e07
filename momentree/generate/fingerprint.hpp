#pragma once
#include <string>

#include <momentree/tree/tree.hpp>

namespace momentree {

/// All that evaluate_rates reads of a tree, as bytes: trees with equal fingerprints run the same operations on the same
/// constants.
std::string fingerprint(const Tree& tree);

}  // namespace momentree
