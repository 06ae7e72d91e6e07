#include <momentree/export/picture/labels.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace momentree::io {

LabelPlacer::LabelPlacer(const Rect& picture)
    : picture_(picture),
      columns_(static_cast<int>(picture.width / cell_) + 1),
      rows_(static_cast<int>(picture.height / cell_) + 1),
      inked_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

void LabelPlacer::add_line(const Point2& from, const Point2& to) {
  const int steps = 1 + static_cast<int>(std::min(std::hypot(to.x - from.x, to.y - from.y) / (0.5 * cell_), 1e4));
  for (int k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) / steps;
    const int column = static_cast<int>((from.x + t * (to.x - from.x) - picture_.x) / cell_);
    const int row = static_cast<int>((from.y + t * (to.y - from.y) - picture_.y) / cell_);
    if (column >= 0 && column < columns_ && row >= 0 && row < rows_)
      inked_[static_cast<std::size_t>(row * columns_ + column)] = 1;
  }
}

int LabelPlacer::ink(const Rect& box) const {
  int count = 0;
  const int c0 = std::max(0, static_cast<int>((box.x - picture_.x) / cell_)),
            r0 = std::max(0, static_cast<int>((box.y - picture_.y) / cell_));
  const int c1 = std::min(columns_ - 1, static_cast<int>((box.x + box.width - picture_.x) / cell_));
  const int r1 = std::min(rows_ - 1, static_cast<int>((box.y + box.height - picture_.y) / cell_));
  for (int r = r0; r <= r1; ++r)
    for (int c = c0; c <= c1; ++c) count += inked_[static_cast<std::size_t>(r * columns_ + c)];
  return count;
}

std::optional<Rect> LabelPlacer::place(const Point2& anchor, const Point2& away, double width, double height) {
  constexpr int directions = 16;
  const double towards = std::atan2(away.y, away.x);
  std::optional<Rect> best;
  double best_cost = 1e9;
  for (const double gap : {4.0, 9.0, 16.0, 26.0}) {
    for (int k = 0; k < directions; ++k) {
      const double turn = std::numbers::pi * (k % 2 == 0 ? k / 2 : -(k + 1) / 2) / (directions / 2);
      const double ux = std::cos(towards + turn), uy = std::sin(towards + turn);
      // The box touches a circle of radius `gap` around the anchor: its nearest point is in the direction (ux, uy).
      const Rect box{anchor.x + ux * (gap + 0.5 * width) - 0.5 * width, anchor.y + uy * (gap + 0.5 * height) - 0.5 * height,
                     width, height};
      const bool inside = box.x >= picture_.x && box.y >= picture_.y && box.x + width <= picture_.x + picture_.width &&
                          box.y + height <= picture_.y + picture_.height;
      if (!inside || std::any_of(boxes_.begin(), boxes_.end(), [&](const Rect& r) { return r.meets(box); })) continue;
      const double crossed = ink(box);
      if (crossed * cell_ * cell_ > 0.5 * width * height) continue;  // it would be unreadable
      const double cost = 6.0 * crossed + gap + 4 * std::abs(turn);
      if (cost < best_cost) best_cost = cost, best = box;
    }
  }
  if (best) boxes_.push_back({best->x - 2, best->y - 1, best->width + 4, best->height + 2});
  return best;
}

}  // namespace momentree::io
