#pragma once
// One frame of a scene as SVG elements.
#include <string>
#include <vector>

#include <momentree/export/picture/scene.hpp>

namespace momentree::io {

/// Maps metres in the view plane to pixels.
struct Placement {
  double scale = 1;  ///< px per metre
  Point2 origin{};   ///< position of the view's origin (px)
  Point2 operator()(const Point2& p) const { return {origin.x + scale * p.x, origin.y + scale * p.y}; }
};

/// Width of links in the picture (px): long thin chains stay visible, few long links are not too thick.
double link_width(const Scene& scene, double scale);

/// Appends a group with everything in the frame; `opacity` distinguishes early frames from late ones.
void append_frame(std::string& svg, const SceneFrame& frame, const Placement& placement, double width, double opacity);

/// Appends planes and solids of the ground, which everything else is drawn over.
void append_ground(std::string& svg, const Scene& scene, const Placement& placement);

/// Convex hull, counter-clockwise, without points on its edges.
std::vector<Point2> convex_hull(std::vector<Point2> points);

}  // namespace momentree::io
