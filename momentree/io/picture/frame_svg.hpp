#pragma once
// One frame of a scene as SVG elements.
#include <string>
#include <vector>

#include <momentree/io/picture/scene.hpp>

namespace momentree::io {

/// From metres in the plane of the view to pixels.
struct Placement {
  double scale = 1;  ///< px per metre
  Point2 origin{};   ///< where the view's origin lies (px)
  Point2 operator()(const Point2& p) const { return {origin.x + scale * p.x, origin.y + scale * p.y}; }
};

/// Width of links in the picture (px): of long thin chains a visible least, of few long links not clumsy.
double link_width(const Scene& scene, double scale);

/// Appends a group with everything of the frame; `opacity` tells early frames from late ones.
void append_frame(std::string& svg, const SceneFrame& frame, const Placement& placement, double width, double opacity);

/// Convex hull, counter-clockwise, without points on its edges.
std::vector<Point2> convex_hull(std::vector<Point2> points);

}  // namespace momentree::io
