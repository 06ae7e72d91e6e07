#pragma once
// Per-body memory of the recursions; allocated once, reused by every evaluation.
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/base/inline.hpp>
#include <momentree/joint/link_constants.hpp>
#include <momentree/joint/revolute_record.hpp>
#include <momentree/tree/state.hpp>

namespace momentree {

/// Power at an instant (W): dissipated by dampers and absorbed by soft stops (including what they store), and work of efforts.
struct Power {
  double dissipated = 0, work = 0;
};

/// Pose and motion of a body's kernel frame. `R`: body axes to world axes; `r`: origin in the world (m); `velocity` in body axes.
template <class T>
struct Kinematics {
  Matrix3<T> R;
  Vector3<T> r;
  Motion<T> velocity;
};

/// Memory for numbers that are written before they are read: allocated but not touched.
struct FreeUntouched {
  std::align_val_t alignment{};
  MOMENTREE_INLINE void operator()(void* memory) const { ::operator delete(memory, alignment); }
};
template <class T>
using Untouched = std::unique_ptr<T[], FreeUntouched>;
template <class T>
MOMENTREE_INLINE Untouched<T> untouched(std::size_t count) {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
  constexpr std::align_val_t alignment{alignof(T) > 16 ? alignof(T) : 16};
  void* const memory = ::operator new((count > 0 ? count : 1) * sizeof(T), alignment);
  return Untouched<T>(static_cast<T*>(memory), FreeUntouched{alignment});
}

/// Buffers for paired branches, indexed by the first one's body.
struct PairWorkspace {
  Untouched<ArmatureRecord<BodyPair>> records;
  Untouched<Inboard<BodyPair>> child_sums;
  Untouched<Outboard<BodyPair>> parent_states;
};
struct NoPairs {};

/// The states whose results a workspace holds. A moved-from workspace holds none and has capacity 0.
struct WorkspaceStamps {
  /// State and topology of the records, v, qdot and pdot; none after a stage of an integrator.
  Stamp evaluated;
  /// State and topology of the poses and velocities in `bodies`.
  Stamp located;
  /// State and topology of `a`, `inboard_accelerations` and `reduced_bias_wrenches`.
  Stamp accelerated;
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
  explicit Workspace(const Tree& tree)
      : WorkspaceStamps(tree.bodies()),
        cos(make(tree, 2, 3)),
        sin(make(tree, 2, 3)),
        v(make(tree, 6)),
        qdot(make(tree, 7)),
        pdot(make(tree, 6)),
        a(make(tree, 6)),
        impulse(make(tree, 6)),
        passive(make(tree, 1)),
        records(untouched<T>(tree.record_capacity())),
        child_sums(by_body<Inboard<T>>(tree)),
        parent_states(by_body<Outboard<T>>(tree)),
        child_wrenches(by_body<Force<T>>(tree)),
        parent_accelerations(by_body<Motion<T>>(tree)),
        in_plane_child_sums(by_body<InPlaneInboard<T>>(tree)),
        in_plane_parent_states(by_body<InPlaneOutboard<T>>(tree)),
        motions(by_body<BodySweep<T>>(tree)),
        inboard_accelerations(by_body<Motion<T>>(tree)),
        reduced_bias_wrenches(by_body<Force<T>>(tree)),
        loads(by_body<Force<T>>(tree)),
        path(by_body<int>(tree)),
        bodies(by_body<Kinematics<T>>(tree)) {
    if constexpr (has_pair_lanes && std::is_same_v<T, double>)
      pairs = {by_body<ArmatureRecord<BodyPair>>(tree), by_body<Inboard<BodyPair>>(tree), by_body<Outboard<BodyPair>>(tree)};
  }

  /// The record of body b, whose joint has kernels K. `tree`: a Tree or an UncheckedTree.
  template <class K, class AnyTree>
  typename K::template Record<T>& record(const AnyTree& tree, int b) const {
    using Record = typename K::template Record<T>;
    static_assert(sizeof(Record) % sizeof(T) == 0 && alignof(Record) <= alignof(T) && std::is_trivially_copyable_v<Record>);
    return *reinterpret_cast<Record*>(records.get() + tree.record(b));
  }

  /// The records of a kernel run, contiguous in memory.
  template <class K, class AnyTree>
  typename K::template Record<T>* records_of(const AnyTree& tree, const KernelRun& run) const {
    return &record<K>(tree, tree.order()[static_cast<std::size_t>(run.begin)]);
  }

  using Array = Untouched<T>;
  Array cos, sin;          ///< of the joint angles including θ0; for a plane mechanism in a stage, of the absolute body angles
  Array v, qdot, pdot, a;  ///< packed as p, q, p, p; a = v̇
  Array impulse;           ///< scratch of impacts, packed as p
  Array passive;           ///< by body: forces on its driven joint other than the motion's own effort
  Array records;
  Power power;
  Untouched<Inboard<T>> child_sums;      ///< by body, inward: sum of its children except the first
  Untouched<Outboard<T>> parent_states;  ///< by body, outward: its output for children except the first
  Untouched<Force<T>> child_wrenches;    ///< the same for the second recursion
  Untouched<Motion<T>> parent_accelerations;
  Untouched<InPlaneInboard<T>> in_plane_child_sums;  ///< and for plane mechanisms
  Untouched<InPlaneOutboard<T>> in_plane_parent_states;
  Untouched<BodySweep<T>> motions;             ///< of the state in `evaluated`
  Untouched<Motion<T>> inboard_accelerations;  ///< a′ = Ω̇ − E u̇ of each body, less gravity; in its kernel frame
  Untouched<Force<T>> reduced_bias_wrenches;  ///< Ŵ of Tr = M̂ a′ + Ŵ, the wrench of the inboard joint on the body; kernel frame
  Untouched<Force<T>> loads;                  ///< T: external wrench on each of the tree's loaded bodies, kernel frame
  Untouched<int> path;                        ///< scratch of topology changes that walk from a root to a body
  Untouched<Kinematics<T>> bodies;
  [[no_unique_address]] std::conditional_t<std::is_same_v<T, double>, PairWorkspace, NoPairs> pairs;

 private:
  static Array make(const Tree& tree, int each, int more = 0) {
    return untouched<T>(static_cast<std::size_t>(each) * static_cast<std::size_t>(tree.bodies()) +
                        static_cast<std::size_t>(more));
  }
  template <class U>
  static Untouched<U> by_body(const Tree& tree) {
    return untouched<U>(static_cast<std::size_t>(tree.bodies()));
  }
};

/// True if the workspace holds the evaluation (or the accelerations) of this state on this tree, both in their present form.
inline bool evaluated_on(const Tree& tree, const State& state, const Workspace<double>& workspace) noexcept {
  return workspace.evaluated == state.stamp() && state.topology() == tree.revision();
}
inline bool accelerated_on(const Tree& tree, const State& state, const Workspace<double>& workspace) noexcept {
  return workspace.accelerated == state.stamp() && state.topology() == tree.revision();
}
/// The requirements that are reported if these are false.
inline constexpr const char* edited_state = "the state's Edit has ended: close its scope first";
inline constexpr const char* foreign_state = "the state belongs to this tree as it is now";
inline const char* stale_workspace(const State& state) {
  return state.being_edited()
             ? edited_state
             : "the workspace was evaluated with this state and this tree as they are now: call forward_dynamics first";
}
inline const char* stale_accelerations(const State& state) {
  return state.being_edited()
             ? edited_state
             : "the workspace holds the accelerations of this state and this tree as they are now: call accelerate first";
}
inline constexpr const char* inside_function =
    "a function called by an evaluation reads only the EvaluationContext that it is given";

}  // namespace momentree
