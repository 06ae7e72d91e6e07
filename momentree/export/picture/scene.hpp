#pragma once
// The picture in metres: the primitives of each frame in the view plane, independent of SVG.
#include <string>
#include <vector>

#include <momentree/export/picture/projection.hpp>
#include <momentree/results/recording/recording.hpp>

namespace momentree::io {

/// One primitive. A line joins the points, a dot marks one; an area is the convex hull of the points, enlarged by `radius` (m);
/// an outline consists of closed loops, and covers what they wind around.
struct Primitive {
  /// displacement: from a joint in its parent to the joint in its child; spring: between its ends
  enum class Kind { line, displacement, spring, area, outline, dot };
  Kind kind = Kind::line;
  std::vector<Point2> points{};
  double radius = 0;
  int mechanism = 0;
  double depth = 0;                 ///< the farthest primitives are drawn first
  std::string colour{};             ///< the shape's own colour; empty: the mechanism's
  std::vector<std::size_t> ends{};  ///< of an outline: where in `points` each of its loops ends
};

struct SceneFrame {
  double time = 0;
  std::vector<Primitive> primitives;
  std::vector<Point2> joints;  ///< where bodies are joined
  std::vector<Point2> ends;    ///< for each present mechanism, the point farthest from its root, where a label can go
  std::vector<Point2> roots;   ///< the roots that belong to `ends`
};

struct SceneEvent {
  double time = 0;
  std::string text;
  std::vector<Point2> places;  ///< of the broken joints
};

struct Box2 {
  Point2 low{1e300, 1e300}, high{-1e300, -1e300};
  void add(const Point2& p, double radius = 0);
  double width() const { return high.x - low.x; }
  double height() const { return high.y - low.y; }
};

struct Scene {
  View view;
  std::vector<SceneFrame> frames;
  std::vector<Point2> anchors;  ///< points where a mechanism is joined to the ground
  std::vector<SceneEvent> events;
  int impacts = 0;                ///< of joints on their stops
  int contacts = 0;               ///< impacts of bodies on each other
  std::vector<Primitive> ground;  ///< solids of the ground, the farthest first
  /// Corners of a part of each plane below the motion, in order; edge on, they are on a line.
  std::vector<std::vector<Point2>> planes;
  Box2 bounds;
  bool has_areas = false;     ///< bodies with shapes, which cover what is behind them
  double typical_length = 0;  ///< median length of the lines in the picture (m)
};

/// Every point that will be drawn (world frame, m), for choose_view.
std::vector<Vec3> drawn_points(const Recording& run);

Scene build_scene(const Recording& run, const View& view);

}  // namespace momentree::io
