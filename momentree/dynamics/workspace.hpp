#pragma once
// What the recursions need per body; allocated once, reused by every evaluation.
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

/// Power at an instant (W): what dampers take, and soft stops (with what they store), what efforts give.
struct Power {
  double dissipated = 0, work = 0;
};

/// Pose and motion of a body's kernel frame. `R`: body axes to world axes.
template <class T>
struct Kinematics {
  Matrix3<T> R;
  Vector3<T> r;
  Motion<T> velocity;
};

/// Memory for numbers that are written before they are read: allocated, not touched.
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

/// What pairs of branches need that are swept at once, by the first one's body.
struct PairWorkspace {
  Untouched<ArmatureRecord<BodyPair>> records;
  Untouched<Inboard<BodyPair>> child_sums;
  Untouched<Outboard<BodyPair>> parent_states;
};
struct NoPairs {};

/// What a work is of. A moved-from work is of nothing and has room for nothing.
struct WorkspaceStamps {
  /// Of which state and topology the records, v, qdot, pdot are; nothing after a stage of an integrator.
  Stamp evaluated;
  /// Of which the poses and velocities in `bodies` are.
  Stamp located;
  /// Of which a, `approaches` and `demands` are.
  Stamp accelerated;
  /// Numbers of bodies that it has room for.
  int capacity() const { return capacity_; }
  /// True while an evaluation calls a function of the user's: the work is between two of its steps then.
  bool in_function = false;

  WorkspaceStamps() = default;
  explicit WorkspaceStamps(int bodies) : capacity_(bodies) {}
  WorkspaceStamps(WorkspaceStamps&& other) noexcept { *this = std::move(other); }
  WorkspaceStamps& operator=(WorkspaceStamps&& other) noexcept {
    MT_REQUIRE(!in_function && !other.in_function, "a function that an evaluation calls leaves the work where it is");
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

/// Scratch of the sweeps for one tree. Arrays are as long as any later topology needs; pages that no evaluation has written to
/// cost nothing. One thread at a time uses it. Arrays are plain memory: an index beyond what the tree has is not noticed. A stage
/// writes 24 numbers per pin beside its record, forward_dynamics the motions of bodies, too.
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

  /// The record of body b, whose joint has kernels K. The tree: a Tree, or an UncheckedTree.
  template <class K, class AnyTree>
  typename K::template Record<T>& record(const AnyTree& tree, int b) const {
    using Record = typename K::template Record<T>;
    static_assert(sizeof(Record) % sizeof(T) == 0 && alignof(Record) <= alignof(T) && std::is_trivially_copyable_v<Record>);
    return *reinterpret_cast<Record*>(records.get() + tree.record(b));
  }

  /// Those of a stretch of the order, one behind the other.
  template <class K, class AnyTree>
  typename K::template Record<T>* records_of(const AnyTree& tree, const KernelRun& run) const {
    return &record<K>(tree, tree.order()[static_cast<std::size_t>(run.begin)]);
  }

  using Array = Untouched<T>;
  Array cos, sin;          ///< of the joints' angles, θ0 among them; in a mechanism in a plane, at a stage, of the bodies'
  Array v, qdot, pdot, a;  ///< packed as p, q, p, p; a = v̇
  Array impulse;           ///< scratch of impacts, packed as p
  Array passive;           ///< by body: what acts on its driven joint beside the motion's own effort
  Array records;
  Power power;
  Untouched<Inboard<T>> child_sums;      ///< by body: what its children but the first ask, on the way in
  Untouched<Outboard<T>> parent_states;  ///< by body: what waits for children but the first, on the way out
  Untouched<Force<T>> child_wrenches;    ///< the same of the second recursion
  Untouched<Motion<T>> parent_accelerations;
  Untouched<InPlaneInboard<T>> in_plane_child_sums;  ///< and of mechanisms in a plane
  Untouched<InPlaneOutboard<T>> in_plane_parent_states;
  Untouched<BodySweep<T>> motions;             ///< of the state of `evaluated`
  Untouched<Motion<T>> inboard_accelerations;  ///< a′ = Ω̇ − E u̇ of each body, less gravity, as felt in the body; kernel frame
  Untouched<Force<T>> reduced_bias_wrenches;  ///< W of Tr = M̂ a′ + W, the wrench of the inboard joint on the body; kernel frame
  Untouched<Force<T>> loads;                  ///< T: what acts on each of the tree's loaded bodies from outside, kernel frame
  Untouched<int> path;                        ///< scratch of changes that walk from a root to a body
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

/// True where the work holds the evaluation of this state on this tree, as both are now; the accelerations of it.
inline bool evaluated_on(const Tree& tree, const State& state, const Workspace<double>& workspace) noexcept {
  return workspace.evaluated == state.stamp() && state.topology() == tree.revision();
}
inline bool accelerated_on(const Tree& tree, const State& state, const Workspace<double>& workspace) noexcept {
  return workspace.accelerated == state.stamp() && state.topology() == tree.revision();
}
/// What is expected where they are false.
inline constexpr const char* edited_state = "the state's Edit has ended: close its scope first";
inline constexpr const char* foreign_state = "the state is one of this tree as it is now";
inline const char* stale_workspace(const State& state) {
  return state.being_edited() ? edited_state
                              : "the work was evaluated on this state and this tree as they are now: call forward_dynamics first";
}
inline const char* stale_accelerations(const State& state) {
  return state.being_edited()
             ? edited_state
             : "the work has the accelerations of this state and this tree as they are now: call accelerate first";
}
inline constexpr const char* inside_function =
    "a function that an evaluation calls reads the Moment that it is given, nothing else";

}  // namespace momentree
