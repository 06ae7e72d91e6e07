#pragma once
// What stands around the motion: title, legend, axes, scale.
#include <string>
#include <string_view>

#include <momentree/io/picture/scene.hpp>

namespace momentree::io {

struct WordStyle {
  double size = 13;
  const char* colour = "#3d4754";
  const char* anchor = "start";
  bool bold = false;
  bool halo = false;  ///< a white edge, to be read upon lines
};

/// A text element at the left end (or middle, or right end) of its baseline.
std::string svg_words(std::string_view text, const Point2& at, const WordStyle& style = {});

/// The sign of an event: a small cross.
std::string event_mark(const Point2& at);

/// One sentence about the run, for those who cannot see it.
std::string description(const Recording& run);

struct Page {
  double width, margin;
};

/// Title, what is shown, colours of the mechanisms, events. `faded`: early frames are paler. Returns where it ends.
double append_header(std::string& svg, const Recording& run, const Scene& scene, bool faded, const Page& page);

/// The world's axes as the view shows them, about `at`.
void append_axes(std::string& svg, const View& view, const Point2& at);

/// A bar of a round length that ends at `right`.
void append_scale_bar(std::string& svg, double scale, const Point2& right);

}  // namespace momentree::io
