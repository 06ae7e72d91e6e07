#pragma once
// `momentree view DIR --svg FILE`: a run as one picture, like Figure 3 of the paper: a frame every 0.2 s, mechanisms
// distinguished by colour, a small disk where one is joined to the ground.
#include <filesystem>
#include <optional>
#include <string>

#include <momentree/export/picture/projection.hpp>
#include <momentree/results/recording/recording.hpp>

namespace momentree::io {

struct PictureOptions {
  double every = 0;          ///< seconds between frames; 0: 0.2 s, or a round number that gives 4 to 60 frames if 0.2 s does not
  std::optional<Vec3> look;  ///< direction in which the viewer looks; none: see choose_view
  enum class Layout { overlay, multiples } layout = Layout::overlay;  ///< all frames in one picture, or side by side
};

/// The picture as an SVG document.
std::string draw_svg(const Recording& run, const PictureOptions& options = {});

/// Reads a result directory, draws it, writes the file. Throws Error.
void write_svg(const std::filesystem::path& directory, const std::filesystem::path& file, const PictureOptions& options = {});

}  // namespace momentree::io
