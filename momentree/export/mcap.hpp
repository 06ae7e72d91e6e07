#pragma once
// A run as an MCAP file with the messages of Foxglove in JSON.
#include <filesystem>
#include <string>

#include <momentree/export/drawing.hpp>

namespace momentree::io {

/// The bytes of an .mcap file. `directory`: the result that was drawn; its joints.csv, energy.csv and springs.csv are read, if
/// they exist. Times are those of the run; if it starts before zero, its start is at zero. Throws Error with the file and the
/// line.
///
/// /tf: foxglove.FrameTransforms, the poses of all bodies in the frame `world`, a message per row. /scene: foxglove.SceneUpdate,
/// solids in the colours of mechanisms, at the start and at each change; /scene/own_colours: the others, at the start;
/// /scene/bars: springs and the bars of joints that were made, at each row. /joints, /springs, /energy: the tables. /events:
/// foxglove.Log.
std::string mcap_of(const Drawing& drawing, const std::filesystem::path& directory);

}  // namespace momentree::io
