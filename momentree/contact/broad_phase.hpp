#pragma once
// Which of many solids are near each other, by balls around them.
#include <span>
#include <utility>
#include <vector>

#include <momentree/math/vec.hpp>

namespace momentree::contact {

/// A ball around a solid, in the world.
struct Ball {
  Vec3 centre{};
  double radius = 0;
};

/// Sweep and prune: the balls sorted along the axis along which they are spread most. It keeps their order, in which they are
/// nearly sorted the next time.
class BroadPhase {
 public:
  /// Pairs of numbers of balls that overlap, the smaller one first, in ascending order. They stay valid until the next call.
  std::span<const std::pair<int, int>> find(std::span<const Ball> balls);

 private:
  std::vector<int> order_;
  std::vector<std::pair<int, int>> found_;
};

}  // namespace momentree::contact
