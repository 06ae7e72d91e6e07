#pragma once
// Per-body memory of the recursions; allocated once, reused by every evaluation.
#include <array>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/base/inline.hpp>
#include <momentree/joint/passes.hpp>
#include <momentree/tree/state.hpp>

namespace momentree {

// Memory of the recursions, defined with their kernels.
template <class T>
struct Motion;
template <class T>
struct Force;
template <class T>
struct Kinematics;
template <class T>
struct Inboard;
template <class T>
struct Outboard;
template <class T>
struct InPlaneInboard;
template <class T>
struct InPlaneOutboard;
template <class T>
struct BodySweep;
template <class T>
struct BodyBias;
struct LoopWorkspace;
class StepTable;
struct ContactWorkspace;

/// Power at an instant (W): dissipated by dampers and absorbed by soft stops (including what they store), and work of efforts.
struct Power {
  double dissipated = 0, work = 0;
};

namespace detail {
/// Memory for numbers that are written before they are read: allocated but not touched.
struct FreeUntouched {
  std::align_val_t alignment{};
  MOMENTREE_INLINE void operator()(void* memory) const { ::operator delete(memory, alignment); }
};
template <class T>
using Untouched = std::unique_ptr<T[], FreeUntouched>;
}  // namespace detail

struct DeleteStepTable {
  void operator()(StepTable* table) const noexcept;
};
using OwnStepTable = std::unique_ptr<StepTable, DeleteStepTable>;

/// The states whose results a workspace holds. A moved-from workspace holds none and has capacity 0.
struct WorkspaceStamps {
  /// State and topology of the records, v, qdot and pdot; none after a stage of an integrator.
  Stamp evaluated;
  /// State and topology of the poses and velocities in `bodies`.
  Stamp located;
  /// State and topology of `a`, `inboard_accelerations` and `reduced_bias_wrenches`.
  Stamp accelerated;
  /// State and topology of `pdot` of a state in velocities.
  Stamp rated;
  /// Largest number of bodies.
  int capacity() const { return capacity_; }
  /// True while an evaluation calls a user function: the workspace is then in the middle of that evaluation.
  bool in_function = false;

  WorkspaceStamps() = default;
  explicit WorkspaceStamps(int bodies) : capacity_(bodies) {}
  WorkspaceStamps(WorkspaceStamps&& other) noexcept { *this = std::move(other); }
  WorkspaceStamps& operator=(WorkspaceStamps&& other) noexcept {
    MT_REQUIRE(!in_function && !other.in_function, "a function called by an evaluation does not move the workspace");
    evaluated = std::exchange(other.evaluated, {});
    located = std::exchange(other.located, {});
    accelerated = std::exchange(other.accelerated, {});
    rated = std::exchange(other.rated, {});
    capacity_ = std::exchange(other.capacity_, 0);
    return *this;
  }
  ~WorkspaceStamps() = default;

 private:
  int capacity_ = 0;
};

/// Working memory of the recursions for one tree, used by one thread at a time. Its arrays are large enough for any later
/// topology; pages that no evaluation has written cost nothing. Indices are not checked. A stage writes 24 numbers per revolute
/// joint in addition to its record; forward_dynamics also writes the motions of bodies.
template <class T>
class Workspace : public WorkspaceStamps {
 public:
  Workspace() = default;
  explicit Workspace(const Tree& tree);

  /// The record of body b, whose joint has kernels K. `tree`: a Tree or an UncheckedTree.
  template <class K, class AnyTree>
  typename K::template Record<T>& record(const AnyTree& tree, int b) const;
  /// The records of a kernel run, contiguous in memory.
  template <class K, class AnyTree>
  typename K::template Record<T>* records_of(const AnyTree& tree, const KernelRun& run) const;

  using Array = detail::Untouched<T>;
  Array cos, sin;          ///< of the joint angles including θ0; for a plane mechanism in a stage, of the absolute body angles
  Array v, qdot, pdot, a;  ///< packed as p, q, p, p; a = v̇
  Array p;                 ///< momenta of a state in velocities; with loops, ṗ of a state in momenta
  Array impulse;           ///< scratch of impacts, packed as p
  Array passive;           ///< by body: forces on its driven joint other than the motion's own effort
  Array records;
  Power power;
  detail::Untouched<Inboard<T>> child_sums;      ///< by body, inward: sum of its children except the first
  detail::Untouched<Outboard<T>> parent_states;  ///< by body, outward: its output for children except the first
  detail::Untouched<Force<T>> child_wrenches;    ///< the same for the second recursion
  detail::Untouched<Motion<T>> parent_accelerations;
  struct InPlane {  ///< the first two for plane mechanisms
    detail::Untouched<InPlaneInboard<T>> child_sums;
    detail::Untouched<InPlaneOutboard<T>> parent_states;
  };
  InPlane in_plane;
  detail::Untouched<BodySweep<T>> motions;             ///< of the state in `evaluated`
  detail::Untouched<Motion<T>> inboard_accelerations;  ///< a′ = Ω̇ − E u̇ of each body, less gravity; in its kernel frame
  detail::Untouched<Force<T>>
      reduced_bias_wrenches;              ///< Ŵ of Tr = M̂ a′ + Ŵ, the wrench of the inboard joint on the body; kernel frame
  detail::Untouched<Force<T>> loads;      ///< T: external wrench on each of the tree's loaded bodies, kernel frame
  detail::Untouched<BodyBias<T>> biases;  ///< of a state, or stage, in velocities
  detail::Untouched<Force<T>> carried;    ///< momenta of bodies during a change of a state in velocities
  detail::Untouched<int> path;            ///< scratch of topology changes that walk from a root to a body
  detail::Untouched<Kinematics<T>> bodies;
  /// The passes; null: not for this scalar, or, of stages, they belong to others.
  std::array<OwnStepTable, kinds_of_passes> tables{};
  OwnStepTable& table(Passes passes) { return tables[static_cast<std::size_t>(passes)]; }
  const StepTable* kept_steps = nullptr;  ///< of passes that keep results, if they belong to others
  const StepTable* steps = nullptr;       ///< those of the present stage
  Array step_records;                     ///< of these …
  std::uint64_t step_records_of = 0;      ///< … or others: see StepTable::prepare
  std::unique_ptr<LoopWorkspace, void (*)(LoopWorkspace*)> loops{nullptr, nullptr};           ///< only with closed loops
  std::unique_ptr<ContactWorkspace, void (*)(ContactWorkspace*)> contacts{nullptr, nullptr};  ///< only with contacts
};

extern template Workspace<double>::Workspace(const Tree& tree);

}  // namespace momentree
