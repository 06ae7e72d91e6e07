#pragma once
// A model as the programs peer-* of bench/peers read it.
#include <string>

#include <momentree/tree/model.hpp>

namespace momentree::cli {

/// The moving bodies of a model, what is welded to each a part of it, in frames whose z is the joint's axis: a line with the
/// name, then a line for each body with its parent's number (−1: the ground), `pin`, `slide` or `free`, where its joint's frame
/// stands in the parent's (rotation by rows, position in m), mass (kg), centre of mass, and inertia about it (xx yy zz xy xz yz)
/// in the body's frame. What acts in joints and on bodies is left out, rotors too: engines differ in what they have of it. Throws
/// Error for what the programs do not take: joints of other kinds, free ones other than that of a single root.
std::string peer_links(const std::string& name, const Model& model);

}  // namespace momentree::cli
