#pragma once
// The bodies of a tree with their steps, in the order in which the passes call them.
#include <array>
#include <cstdint>
#include <vector>

#include <momentree/derive/step.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

struct CompiledStep;

/// What steps read that are not machine code: those of joints that are locked or reversed, or that have an armature for which
/// their kind has no kernels.
struct GenericBody {
  std::array<StepFunction, derive::Step::passes> passes{};
  LinkConstants link{};
  int body = 0;
  bool leaf = false, root = false;
};
/// Their passes: the generic functions of the kinds, on a GenericBody. `adds`: to the contributions of other children.
[[nodiscard]] std::array<StepFunction, derive::Step::passes> generic_steps(Kind kind, Variant variant, bool adds) noexcept;

/// For the stages in velocities of the mechanisms of one tree, except those in a plane. Welded bodies are one body.
class StepTable {
 public:
  /// Follows the tree's topology. False if there is no machine code here, or if it would not be faster.
  /// Allocates where the topology has changed.
  [[nodiscard]] bool follow(const Tree& tree) noexcept;

  // The passes, after `follow`: velocities outward, then with joint forces in `a` inward, and outward with the acceleration of
  // the ground (m/s²).
  void velocities(const StepArrays& arrays) const noexcept;
  void inboard(const StepArrays& arrays) const noexcept;
  void outboard(const StepArrays& arrays, const Vec3& acceleration) const noexcept;

 private:
  /// What bodies with equal links share.
  struct Link {
    derive::LinkNumbers numbers{};
    derive::StepKey form{};  ///< without its pattern
    CompiledStep* step = nullptr;
    unsigned used = 0;          ///< the number of the last rebuilding that found it
    std::size_t constants = 0;  ///< the first one
  };
  /// The tree as the steps see it.
  struct Body {
    int parent = -1;  ///< that is not welded to this one; −1: the ground
    int children = 0;
    bool started = false;  ///< a child has contributed
    bool adds = false;     ///< to the contributions of other children
    int sum = 0;           ///< whose memory holds the contributions of its children
    int motion = 0;        ///< whose memory holds what its children read
    int link = -1;         ///< −1: it is generic
  };

  bool rebuild(const Tree& tree);
  void find_bodies(const Tree& tree);
  bool find_link(const Tree& tree, int b, int& previous);
  LinkConstants link_of(const Tree& tree, int b) const;
  void share_memory();
  bool add_entries(const Tree& tree);

  std::uint64_t revision_ = 0;
  unsigned rebuilt_ = 0;
  std::vector<const CompiledStep*> steps_;  ///< different ones
  bool serves_ = false;
  std::vector<Body> bodies_;
  std::vector<int> moving_;        ///< bodies that are not welded to their parents, outward
  std::vector<RigidMass> welded_;  ///< by body: what is welded to it
  std::vector<Link> links_;
  std::vector<double> constants_;
  std::vector<GenericBody> generic_;  ///< in the order of moving_
  std::vector<int> roots_;            ///< places of motions
  std::vector<StepEntry> velocities_, inboard_, outboard_;
};

}  // namespace momentree
