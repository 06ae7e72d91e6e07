#pragma once
// The bodies of a tree with their steps, in the order in which the passes call them.
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <momentree/dynamics/steps/step_links.hpp>
#include <momentree/dynamics/steps/step_scalar.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// What generic steps read: those of joints that are locked or reversed, or that have an armature for which their kind has no
/// kernels, and all where there is no machine code.
struct GenericBody {
  StepFunctions passes{};
  LinkConstants link{};
  double mass = 0;  ///< of the body and of all bodies outboard (kg)
  int body = 0;
  bool aligned = false, leaf = false, root = false, alone = false;  ///< see PassBody
};

/// For passes over the mechanisms of one tree. Stages leave out those in a plane, and welded bodies are one body. Once it follows
/// a tree it may be used by many threads, each with arrays of its own.
class StepTable {
 public:
  /// With memory for trees of so many bodies, which it then follows even if there is no more.
  explicit StepTable(const StepScalar& scalar, int bodies = 0);

  /// Follows the tree's topology. False if there is no memory, or if 32 bits do not count that of so many bodies. Allocates where
  /// the topology has changed.
  [[nodiscard]] bool follow(const Tree& tree) noexcept;

  // The passes, after `follow`. In velocities: velocities outward, then with joint forces in `a` inward, and outward with the
  // acceleration of the ground. In momenta: inward, and outward with gravity. `base`: this vector, a Vector3 of the scalar.
  // `begin`, `end`: only for bodies with these places in the tree's order; of passes that keep results.
  void velocities(const StepArrays& arrays) const noexcept;
  void inboard(const StepArrays& arrays, int begin = 0, int end = all_bodies) const noexcept;
  void outboard(const StepArrays& arrays, const void* base, int begin = 0, int end = all_bodies) const noexcept;
  /// Writes what records have to contain before the first pass, unless `made_for` says that it was done; updates that.
  void prepare(void* records, std::uint64_t& made_for) const noexcept;
  /// The step of a body, after `follow`; null: it has a generic one, is welded or moves in a plane.
  [[nodiscard]] const derive::Step* step_of(int body) const noexcept;

  static constexpr int all_bodies = std::numeric_limits<int>::max();

 private:
  struct Root {
    int place = 0, body = 0;
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
    int former = -1;       ///< another link that it had: methods alternate between a tree and one with other armatures
  };

  void run(std::span<const StepEntry> entries, const StepArrays& arrays) const noexcept;
  void rebuild(const Tree& tree);
  void find_bodies(const Tree& tree);
  [[nodiscard]] bool add_steps(const Tree& tree);  ///< false: there is no memory
  void find_links(const Tree& tree, bool general);
  const LinkConstants& link_of(const Tree& tree, int b, LinkConstants& merged) const;
  void share_memory();
  [[nodiscard]] bool add_entries(const Tree& tree);

  StepScalar scalar_;
  std::uint64_t revision_ = ~std::uint64_t{0}, version_ = 0;
  bool serves_ = false;
  bool in_machine_code_ = false;
  StepLinks links_;
  std::vector<Body> bodies_;
  std::vector<int> moving_;        ///< bodies that are not welded to their parents, outward
  std::vector<RigidMass> welded_;  ///< by body: what is welded to it
  std::vector<GenericBody> generic_;
  std::vector<Root> roots_;  ///< in this order
  std::vector<StepEntry> velocities_, inboard_, outboard_;
  /// Masses that records begin with.
  struct Mass {
    std::int32_t record;
    double mass;
  };
  std::vector<Mass> masses_;
};

}  // namespace momentree
