#pragma once
// Which bodies joints hold together: they do not touch each other.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <momentree/tree/tree.hpp>

namespace momentree {

class Connections {
 public:
  /// Those of this tree.
  void update(const Tree& tree);

  /// True if one of two bodies is welded to the other one, or to bodies that are. −1: the ground.
  bool are_welded(int one, int other) const { return first_welded(one) == first_welded(other); }
  /// True if a joint connects two bodies directly. Never with the ground: what a hinge holds there still touches the floor.
  bool are_joined(int one, int other) const {
    if (one < 0 || other < 0) return false;
    return parent_[at(one)] == other || parent_[at(other)] == one ||
           (!loops_.empty() &&
            std::binary_search(loops_.begin(), loops_.end(), std::pair(std::min(one, other), std::max(one, other))));
  }

 private:
  static std::size_t at(int body) { return static_cast<std::size_t>(body); }
  int first_welded(int body) const { return body < 0 ? -1 : welded_[at(body)]; }

  std::vector<int> welded_;                 // by body: the first one of those that it is welded to; −1: the ground
  std::vector<int> parent_;                 // by body
  std::vector<std::pair<int, int>> loops_;  // bodies that loop joints connect, the first one first, in ascending order
  std::uint64_t revision_ = 0;              // of the tree
};

}  // namespace momentree
