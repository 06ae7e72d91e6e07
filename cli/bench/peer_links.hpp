#pragma once
// A model in the text format of the programs peer-* of bench/peers.
#include <string>

#include <momentree/model/model.hpp>

namespace momentree::cli {

/// The moving bodies of a model, merged with the bodies welded to them, in frames whose z axis is the joint's axis. A line with
/// the name, then a line for each body: its parent's index (−1: the ground), `revolute`, `prismatic` or `free`, the pose of its
/// joint's frame in the parent's (rotation by rows, position in m), mass (kg), centre of mass (m), and inertia about it (xx yy zz
/// xy xz yz, kg m²) in the body's frame. Joint forces, forces on bodies and armatures are left out, since engines differ in what
/// they support. Throws Error for what the programs do not support: joints of other kinds, and free joints other than that of a
/// single root.
std::string peer_links(const std::string& name, const Model& model);

}  // namespace momentree::cli
