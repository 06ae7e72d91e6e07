#pragma once
// What the recursions need per body; allocated once, reused by every evaluation.
#include <memory>
#include <span>

#include <momentree/base/check.hpp>
#include <momentree/joint/link.hpp>
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

/// Scratch of the sweeps for one tree. Arrays are as long as any later topology needs; untouched pages cost nothing.
template <class T>
class Work {
 public:
  Work() = default;
  explicit Work(const Tree& tree)
      : cos(make(tree.angle_capacity())),
        sin(make(tree.angle_capacity())),
        angle(make(tree.angle_capacity())),
        v(make(6 * tree.bodies())),
        qdot(make(7 * tree.bodies())),
        pdot(make(6 * tree.bodies())),
        a(make(6 * tree.bodies())),
        impulse(make(6 * tree.bodies())),
        passive(make(tree.bodies())),
        records(make(static_cast<long>(tree.record_capacity()))),
        inlets(std::make_unique_for_overwrite<Inboard<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        outlets(std::make_unique_for_overwrite<Outboard<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        wrench_inlets(std::make_unique_for_overwrite<Force<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        rate_outlets(std::make_unique_for_overwrite<Motion<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        flat_inlets(std::make_unique_for_overwrite<FlatInboard<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        flat_outlets(std::make_unique_for_overwrite<FlatOutboard<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        motions(std::make_unique_for_overwrite<BodySweep<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        approaches(std::make_unique_for_overwrite<Motion<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        demands(std::make_unique_for_overwrite<Force<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        loads(std::make_unique_for_overwrite<Force<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        path(std::make_unique_for_overwrite<int[]>(static_cast<std::size_t>(tree.bodies()))),
        bodies(std::make_unique_for_overwrite<Kinematics<T>[]>(static_cast<std::size_t>(tree.bodies()))),
        capacity_(tree.bodies()) {}

  /// The record of body b, whose joint has kernels K.
  template <class K>
  typename K::template Record<T>& record(const Tree& tree, int b) const {
    using Record = typename K::template Record<T>;
    static_assert(sizeof(Record) % sizeof(T) == 0 && alignof(Record) <= alignof(T) && std::is_trivially_copyable_v<Record>);
    return *reinterpret_cast<Record*>(records.get() + tree.record(b));
  }

  /// Of which state and topology the records, v, qdot, pdot are; nothing after a stage of an integrator.
  Stamp evaluated;
  /// Of which the poses and velocities in `bodies` are.
  Stamp located;
  /// Of which a, `approaches` and `demands` are.
  Stamp accelerated;

  using Array = std::unique_ptr<T[]>;
  Array cos, sin, angle;
  Array v, qdot, pdot, a;  ///< packed as p, q, p, p; a = v̇
  Array impulse;           ///< scratch of impacts, packed as p
  Array passive;           ///< by body: what acts on its driven joint beside the motion's own effort
  Array records;
  Power power;
  std::unique_ptr<Inboard<T>[]> inlets;       ///< by body: what its children but the first ask, on the way in
  std::unique_ptr<Outboard<T>[]> outlets;     ///< by body: what waits for children but the first, on the way out
  std::unique_ptr<Force<T>[]> wrench_inlets;  ///< the same of the second recursion
  std::unique_ptr<Motion<T>[]> rate_outlets;
  std::unique_ptr<FlatInboard<T>[]> flat_inlets;  ///< and of mechanisms in a plane
  std::unique_ptr<FlatOutboard<T>[]> flat_outlets;
  std::unique_ptr<BodySweep<T>[]> motions;  ///< of the state of `evaluated`
  std::unique_ptr<Motion<T>[]> approaches;  ///< a′ = Ω̇ − E u̇ of each body, less gravity, as felt in the body; kernel frame
  std::unique_ptr<Force<T>[]> demands;      ///< W of Tr = M̂ a′ + W, the wrench of the inboard joint on the body; kernel frame
  std::unique_ptr<Force<T>[]> loads;        ///< T: what acts on each of the tree's loaded bodies from outside, kernel frame
  std::unique_ptr<int[]> path;              ///< scratch of changes that walk from a root to a body
  std::unique_ptr<Kinematics<T>[]> bodies;

  /// Numbers of bodies that it has room for.
  int capacity() const { return capacity_; }

 private:
  int capacity_ = 0;
  static Array make(long n) { return std::make_unique_for_overwrite<T[]>(static_cast<std::size_t>(n > 0 ? n : 1)); }
};

}  // namespace momentree
