#pragma once
// The memory of a Workspace, for the recursions.
#include <new>
#include <type_traits>

#include <momentree/base/inline.hpp>
#include <momentree/dynamics/requirements.hpp>
#include <momentree/dynamics/steps/step_scalar.hpp>
#include <momentree/dynamics/workspace.hpp>
#include <momentree/joint/pass_data.hpp>
#include <momentree/tree/kernel_run.hpp>

namespace momentree {

/// Pose and motion of a body's kernel frame. `R`: body axes to world axes; `r`: origin in the world (m); `velocity` in body axes.
template <class T>
struct Kinematics {
  Matrix3<T> R;
  Vector3<T> r;
  Motion<T> velocity;
};

namespace detail {
/// See the constructor of StepTable.
OwnStepTable make_step_table(const StepScalar& scalar, int bodies = 0);
/// Of one world. In instantiate/.
StepScalar double_momenta(bool kept);
StepScalar double_velocities(bool kept);
StepScalar double_accelerations(bool solutions);
StepScalar double_steps(Passes passes);
/// Of operations that are counted.
StepScalar counting_scalar();

template <class T>
MOMENTREE_INLINE Untouched<T> untouched(std::size_t count) {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
  constexpr std::align_val_t alignment{alignof(T) > 16 ? alignof(T) : 16};
  void* const memory = ::operator new((count > 0 ? count : 1) * sizeof(T), alignment);
  return Untouched<T>(static_cast<T*>(memory), FreeUntouched{alignment});
}
}  // namespace detail

template <class T>
Workspace<T>::Workspace(const Tree& tree)
    : WorkspaceStamps(tree.bodies()), records(detail::untouched<T>(tree.tables().record_capacity)) {
  const auto bodies_count = static_cast<std::size_t>(tree.bodies());
  const auto numbers = [&](std::size_t each, std::size_t more = 0) { return detail::untouched<T>(each * bodies_count + more); };
  const auto by_body = [&]<class U>(detail::Untouched<U>& list) { list = detail::untouched<U>(bodies_count); };
  cos = numbers(2, 3), sin = numbers(2, 3);
  v = numbers(6), qdot = numbers(7), pdot = numbers(6), a = numbers(6);
  p = numbers(6), impulse = numbers(6), passive = numbers(1);
  by_body(child_sums), by_body(parent_states), by_body(child_wrenches), by_body(parent_accelerations);
  by_body(in_plane.child_sums), by_body(in_plane.parent_states);
  by_body(motions), by_body(inboard_accelerations), by_body(reduced_bias_wrenches), by_body(loads), by_body(path);
  by_body(biases), by_body(carried), by_body(bodies);
  step_records = detail::untouched<T>(tree.tables().record_capacity);
  if constexpr (std::is_same_v<T, double>) {
    for (std::size_t i = 0; i < tables.size(); ++i) {
      const auto passes = static_cast<Passes>(i);
      tables[i] = detail::make_step_table(detail::double_steps(passes), keeps_results(passes) ? tree.bodies() : 0);
    }
  }
}

template <class T>
template <class K, class AnyTree>
typename K::template Record<T>& Workspace<T>::record(const AnyTree& tree, int b) const {
  using Record = typename K::template Record<T>;
  static_assert(sizeof(Record) % sizeof(T) == 0 && alignof(Record) <= alignof(T) && std::is_trivially_copyable_v<Record>);
  return *reinterpret_cast<Record*>(records.get() + tree.tables().offsets[static_cast<std::size_t>(b)].record);
}

template <class T>
template <class K, class AnyTree>
typename K::template Record<T>* Workspace<T>::records_of(const AnyTree& tree, const KernelRun& run) const {
  return &record<K>(tree, tree.order()[static_cast<std::size_t>(run.begin)]);
}

}  // namespace momentree
