#pragma once
// The parts of the picture around the motion: title, legend, axes, scale.
#include <string>
#include <string_view>

#include <momentree/export/picture/scene.hpp>

namespace momentree::io {

struct WordStyle {
  double size = 13;
  const char* colour = "#3d4754";
  const char* anchor = "start";
  bool bold = false;
  bool halo = false;  ///< white outline, for readability on top of lines
};

/// A text element at the left end (or middle, or right end) of its baseline.
std::string svg_words(std::string_view text, const Point2& at, const WordStyle& style = {});

/// The mark of an event: a small cross.
std::string event_mark(const Point2& at);

/// One sentence about the run, as a text alternative to the picture.
std::string description(const Recording& run);

struct Page {
  double width, margin;
};

/// Title, description, colours of the mechanisms, events. `faded`: early frames are paler. Returns the y of its lower end (px).
double append_header(std::string& svg, const Recording& run, const Scene& scene, bool faded, const Page& page);

/// The world's axes in the view, around `at`.
void append_axes(std::string& svg, const View& view, const Point2& at);

/// A scale bar of a round length that ends at `right`.
void append_scale_bar(std::string& svg, double scale, const Point2& right);

}  // namespace momentree::io
