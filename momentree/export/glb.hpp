#pragma once
// A run as an animated glTF 2.0 file.
#include <string>

#include <momentree/export/drawing.hpp>

namespace momentree::io {

/// The bytes of a .glb file. Throws Error, without a place, if it would have more than 4 GiB.
///
/// The root node turns the world so that gravity points along −y. Below it, each body has a node with its name, whose translation
/// and rotation have a key at each row; times are relative to the first row, in single precision. Below a body are its solids.
/// If its mechanism changes, those in mechanism colours are there once for each colour: scales of 1 and 0, which change in steps,
/// show the present one. Bars are nodes of their own. Extras: of the scene the start, the status and the events; of a body the
/// mechanisms to which it belongs, and from when on.
std::string glb_of(const Drawing& drawing);

}  // namespace momentree::io
