#include <momentree/export/picture/frame_svg.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <momentree/export/picture/svg_text.hpp>

namespace momentree::io {
namespace {

using Kind = Primitive::Kind;

std::string colour_of(const Primitive& p) {
  return safe_colour(p.colour, mechanism_colour(static_cast<std::size_t>(p.mechanism)));
}

/// Joins successive lines of one colour into one path: a chain of 100 links is one element.
class PathWriter {
 public:
  PathWriter(std::string& svg, double width) : svg_(svg), width_(width) {}
  PathWriter(const PathWriter&) = delete;
  PathWriter& operator=(const PathWriter&) = delete;

  void add(const Primitive& p, const Placement& place) {
    const std::string colour = colour_of(p);
    if (colour != colour_ || p.kind != kind_) close();
    colour_ = colour, kind_ = p.kind;
    const std::string from = pixels(place(p.points.front())), to = pixels(place(p.points.back()));
    if (data_.empty() || from != end_)
      data_ += "M" + from + "L" + to;
    else
      data_ += " " + to;
    end_ = to;
  }

  /// Writes what was added; call it at the end.
  void close() {
    if (data_.empty()) return;
    const bool dashed = kind_ == Kind::displacement;
    const double width = dashed ? 1 : kind_ == Kind::spring ? 1.5 : width_;
    svg_ += "<path d=\"" + data_ + "\" stroke=\"" + colour_ + "\" stroke-width=\"" + pixels(width) + "\"" +
            (dashed ? " stroke-dasharray=\"3 3\"" : "") + "/>\n";
    data_.clear();
  }

 private:
  std::string& svg_;
  double width_;
  std::string data_, end_, colour_;
  Kind kind_ = Kind::line;
};

void append_circle(std::string& svg, const Point2& at, double radius, const std::string& attributes) {
  svg += "<circle cx=\"" + pixels(at.x) + "\" cy=\"" + pixels(at.y) + "\" r=\"" + pixels(radius) + "\" " + attributes + "/>\n";
}

/// Points on circles around the points: their hull is the outline of a capsule.
std::vector<Point2> widened(const std::vector<Point2>& points, double radius) {
  constexpr int around = 32;
  std::vector<Point2> rim;
  for (const Point2& p : points)
    for (int k = 0; k < around; ++k) {
      const double a = 2 * std::numbers::pi * k / around;
      rim.push_back({p.x + radius * std::cos(a), p.y + radius * std::sin(a)});
    }
  return rim;
}

/// Shapes are filled with a light tint of their colour, so that overlapping frames do not become darker.
std::string glass_of(const Primitive& p) {
  const std::string colour = colour_of(p);
  return "fill=\"" + tint(colour, p.colour.empty() ? 0.22 : 0.6) + "\" fill-opacity=\"0.85\" stroke=\"" + colour + "\"";
}

void append_outline(std::string& svg, const Primitive& p, const Placement& place) {
  std::string data;
  std::size_t begin = 0;
  for (const std::size_t end : p.ends) {
    std::string last;
    int count = 0;
    for (std::size_t i = std::exchange(begin, end); i < end; ++i) {
      std::string at = pixels(place(p.points[i]));
      if (at == last) continue;  // details below the resolution of the picture
      data += (count == 0 ? "M" : count == 1 ? "L" : " ") + at;
      last = std::move(at), ++count;
    }
    data += "Z";
  }
  svg += "<path d=\"" + data + "\" " + glass_of(p) + " stroke-width=\"0.7\"/>\n";
}

void append_area(std::string& svg, const Primitive& p, const Placement& place) {
  std::vector<Point2> points;
  for (const Point2& at : p.points) points.push_back(place(at));
  points = convex_hull(std::move(points));
  const std::string glass = glass_of(p);
  const double radius = p.radius * place.scale;
  if (points.size() == 1) return append_circle(svg, points.front(), std::max(radius, 2.0), glass);
  if (radius > 0) points = convex_hull(widened(points, radius));
  svg += "<path d=\"";
  for (std::size_t i = 0; i < points.size(); ++i) svg += (i == 0 ? "M" : i == 1 ? "L" : " ") + pixels(points[i]);
  svg += "Z\" " + glass + "/>\n";
}

}  // namespace

double link_width(const Scene& scene, double scale) {
  return std::clamp(0.04 * scene.typical_length * scale, 2.2, scene.has_areas ? 4.0 : 6.0);
}

void append_frame(std::string& svg, const SceneFrame& frame, const Placement& placement, double width, double opacity) {
  svg += "<g opacity=\"" + plain_number(std::round(opacity * 100) / 100) + "\">\n";
  {
    PathWriter path(svg, width);
    for (const Primitive& p : frame.primitives) {
      if (p.kind == Kind::line || p.kind == Kind::displacement || p.kind == Kind::spring) {
        path.add(p, placement);
        continue;
      }
      path.close();
      if (p.kind == Kind::area)
        append_area(svg, p, placement);
      else if (p.kind == Kind::outline)
        append_outline(svg, p, placement);
      else
        append_circle(svg, placement(p.points.front()), 0.8 * width + 1, "fill=\"" + colour_of(p) + "\"");
    }
    path.close();
  }
  if (width >= 4)  // on thin links the joints would not be visible
    for (const Point2& joint : frame.joints) append_circle(svg, placement(joint), 0.3 * width, "fill=\"#fff\"");
  svg += "</g>\n";
}

void append_ground(std::string& svg, const Scene& scene, const Placement& placement) {
  for (const std::vector<Point2>& corners : scene.planes) {
    svg += "<path d=\"";
    for (std::size_t i = 0; i < corners.size(); ++i) svg += (i == 0 ? "M" : i == 1 ? "L" : " ") + pixels(placement(corners[i]));
    svg += "Z\" fill=\"#eef0f3\" stroke=\"#aab2bd\"/>\n";
  }
  for (const Primitive& p : scene.ground)
    p.kind == Kind::area ? append_area(svg, p, placement) : append_outline(svg, p, placement);
}

std::vector<Point2> convex_hull(std::vector<Point2> points) {
  std::sort(points.begin(), points.end(), [](const Point2& a, const Point2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  points.erase(std::unique(points.begin(), points.end(),
                           [](const Point2& a, const Point2& b) { return std::hypot(a.x - b.x, a.y - b.y) < 1e-9; }),
               points.end());
  if (points.size() < 3) return points;
  std::vector<Point2> hull;
  const auto walk = [&](auto begin, auto end) {  // Andrew's monotone chain: the lower half, then the upper half
    const std::size_t start = hull.size();
    for (auto p = begin; p != end; ++p) {
      while (hull.size() >= start + 2) {
        const Point2 &a = hull[hull.size() - 2], &b = hull.back();
        if ((b.x - a.x) * (p->y - a.y) - (b.y - a.y) * (p->x - a.x) > 0) break;
        hull.pop_back();
      }
      hull.push_back(*p);
    }
    hull.pop_back();
  };
  walk(points.begin(), points.end());
  walk(points.rbegin(), points.rend());
  return hull;
}

}  // namespace momentree::io
