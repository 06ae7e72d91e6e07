#pragma once
// Places labels so that they cover neither each other nor the drawing.
#include <optional>
#include <vector>

#include <momentree/export/picture/projection.hpp>

namespace momentree::io {

struct Rect {
  double x = 0, y = 0, width = 0, height = 0;
  bool meets(const Rect& r) const { return x < r.x + r.width && r.x < x + width && y < r.y + r.height && r.y < y + height; }
};

/// Keeps track of the occupied parts of the picture (px) on a coarse grid.
class LabelPlacer {
 public:
  explicit LabelPlacer(const Rect& picture);

  /// A line that labels should not cover.
  void add_line(const Point2& from, const Point2& to);
  /// A box that no label may touch.
  void add_box(const Rect& box) { boxes_.push_back(box); }

  /// A free box of this size near `anchor`, preferably on the side of `away`; it is occupied from then on. Empty if there is
  /// none.
  std::optional<Rect> place(const Point2& anchor, const Point2& away, double width, double height);

 private:
  static constexpr double cell_ = 5;
  int ink(const Rect& box) const;

  Rect picture_;
  int columns_, rows_;
  std::vector<unsigned char> inked_;
  std::vector<Rect> boxes_;
};

}  // namespace momentree::io
