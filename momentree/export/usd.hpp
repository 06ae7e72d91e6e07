#pragma once
// A run as an animated USD file.
#include <string>

#include <momentree/export/drawing.hpp>

namespace momentree::io {

/// The text of a .usda file, in metres and with z upwards.
///
/// The prim /world turns the world so that gravity points along −z. Below it, each body is an Xform, whose translation (double
/// precision) and orientation have a sample at each row; there are 60 time codes per second, and the first row is at 0. Names are
/// valid identifiers; `displayName` is the body's own. Below a body are its solids. Bars are prims of their own, invisible when
/// they are not there. Materials change in steps where mechanisms do. `customLayerData` has the start, the status and the events.
std::string usd_of(const Drawing& drawing);

}  // namespace momentree::io
