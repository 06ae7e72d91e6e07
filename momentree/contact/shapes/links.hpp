#pragma once
// Impulses on the bodies of large trees, carried from body to body: rows with the degrees of freedom of a whole chain of n links
// would take a memory of n² for n points.
#include <array>
#include <cstddef>
#include <vector>

namespace momentree::contact {

/// A body of a tree. Matrices of 6 × 6, by columns; motions and wrenches in the body's axes.
struct Link {
  int group = -1, parent = -1, depth = 0;  ///< the tree's number; in Links, before this one; −1: it is the root
  std::array<double, 36> carried{};        ///< the wrench on the parent, by wrenches on the body
  std::array<double, 36> own{};            ///< the motion by wrenches on the body while the parent rests
  std::array<double, 36> whole{};          ///< the motion by wrenches on the body: find_whole()
};

/// Velocities or displacements.
struct LinksMotion {
  std::vector<double> x;          ///< six of each link, then others
  std::vector<double> sum, sent;  ///< by link: the wrench of impulses on it and outboard of it; what its parent has of that
  std::vector<int> at;            ///< by tree: the link whose sum and x are right; −1: nothing has moved it
};

class Links {
 public:
  /// Forgets all links. How many there will be, and trees.
  void clear(int links, int trees);
  /// The links of a tree follow each other.
  std::vector<Link> all;
  /// Completes the links first … end − 1 of a tree.
  void find_whole(int first, int end);

  /// Nothing moves. `others`: how many numbers follow those of the links.
  void start(LinksMotion& motion, int others) const;
  /// Nothing of a tree moves any more.
  void forget(int tree, LinksMotion& motion) const;
  /// Makes x right for a link. Impulses may then be added to its sum, and what they do to its x.
  void walk(LinksMotion& motion, int to);
  /// Makes sum and x right for all links of a tree.
  void complete(LinksMotion& motion, int tree) const;

 private:
  void up(LinksMotion& motion, int from) const;
  void down(LinksMotion& motion, int to) const;

  std::vector<int> first_;  // by tree: its root; −1: it has no links
  std::vector<int> way_;    // down to a link; scratch
};

}  // namespace momentree::contact
