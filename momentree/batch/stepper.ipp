#pragma once
// Steps in lanes, for either variables; included only by instantiate/*.cpp, each for one instruction set and precision. No
// function here may also occur in other source files unless its name contains the pack (ADR 9; tools/check_lane_symbols).
#include <momentree/batch/stepper.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/integrate/rk4_stages.hpp>

namespace momentree::batch {

/// The rates of y, with all forces, are left to the classes for momenta, velocities and loops. Base: TreeStepper or LoopLanes.
template <class T, class Base = TreeStepper>
class PackStepper : public Base {
 public:
  int lanes() const final { return N; }
  void step(const Tree& tree, const TopologyPlan& plan, const Block& block) noexcept final;

 protected:
  static constexpr int N = T::lanes;
  static constexpr bool is_double = sizeof(T) == N * sizeof(double);
  using Array = std::unique_ptr<T[]>;
  static Array make(int n) { return std::make_unique_for_overwrite<T[]>(static_cast<std::size_t>(n > 0 ? n : 1)); }

  explicit PackStepper(const Tree& tree)
      : workspace_(tree),
        q_(make(7 * tree.bodies())),
        y_(make(6 * tree.bodies())),
        q0_(make(7 * tree.bodies())),
        y0_(make(6 * tree.bodies())),
        q_sum_(make(7 * tree.bodies())),
        y_sum_(make(6 * tree.bodies())) {}

  /// Rates with the joint forces, to workspace_.qdot and ydot(); t by lane.
  virtual void evaluate(const Tree& tree, const TopologyPlan& plan, const double* effort, const double* t, const T* q,
                        const T* y) noexcept = 0;
  virtual const T* ydot() const noexcept = 0;
  /// Whether the next evaluation keeps results, as that of a simulation does at the start of a step, and in all stages if there
  /// are prescribed motions: the bits are then the same.
  bool keeps_ = false;
  /// Before a step.
  virtual void begin(const Tree&, const TopologyPlan&, const Block&) noexcept {}
  /// Corrects q_ and y_ after a step that ended at t, by lane; clears the lanes in which that is impossible.
  virtual void close(const Tree&, const Block&, const double* /*t*/, typename T::Mask& /*plausible*/) noexcept {}
  /// Normalises the quaternions in some lanes.
  void normalise(const Tree& tree, T* q, const bool* lanes) noexcept;
  /// Adds the joint forces to `force`, at the velocities in workspace_.v; the accelerations of prescribed motions in their
  /// places.
  void add_forces(const Tree& tree, const TopologyPlan& plan, const double* effort, const double* t, const T* q,
                  T* force) noexcept;
  static void load(const Tree& tree, const double* q, const double* y, T* to_q, T* to_y) noexcept {
    for (int i = 0; i < tree.nq(); ++i) to_q[i] = T::load(q + i * N);
    for (int i = 0; i < tree.nv(); ++i) to_y[i] = T::load(y + i * N);
  }
  static void store(int n, const T* from, double* to) noexcept {
    for (int i = 0; i < n; ++i) from[i].store(to + i * N);
  }

  Workspace<T> workspace_;
  Array q_, y_;

 private:
  void add_elements(const Tree& tree, int b, const double* t, const T* q, T* force) noexcept;
  void end_step(const Tree& tree, const double* t) noexcept;

  Array q0_, y0_, q_sum_, y_sum_;
};

// Adds the other forces in one joint, lane by lane.
template <class T, class Base>
void PackStepper<T, Base>::add_elements(const Tree& tree, int b, const double* t, const T* q, T* force) noexcept {
  const int nq = coordinates_of(tree, b), nv = dofs_of(tree, b), at = tree.first_p(b);
  for (int lane = 0; lane < N; ++lane) {
    double joint_q[7], u[6], own[6] = {};
    for (int i = 0; i < nq; ++i) joint_q[i] = q[tree.first_q(b) + i][lane];
    for (int i = 0; i < nv; ++i) u[i] = workspace_.v[at + i][lane];
    add_element_forces(tree, b, t[lane], joint_q, u, own);
    for (int i = 0; i < nv; ++i) force[at + i].set(lane, force[at + i][lane] + own[i]);
  }
}

template <class T, class Base>
void PackStepper<T, Base>::add_forces(const Tree& tree, const TopologyPlan& plan, const double* effort, const double* t,
                                      const T* q, T* force) noexcept {
  const int nv = tree.nv();
  const T* const v = workspace_.v.get();
  if (tree.tables().has_forces)
    for (int i = 0; i < nv; ++i) force[i] += tree.tables().effort[i] - tree.tables().damping[i] * v[i];
  if (effort != nullptr)
    for (int i = 0; i < nv; ++i) force[i] += T::load(effort + i * N);
  for (const forces::LinearSpring& s : plan.springs) force[s.p] -= s.stiffness * (q[s.q] - s.rest);
  for (const int b : plan.elements) add_elements(tree, b, t, q, force);
  for (const int b : tree.joints_with().motions)
    for (int lane = 0; lane < N; ++lane) {
      double point[3];
      motion_at(tree, b, t[lane], point);
      force[tree.first_p(b)].set(lane, point[2]);
    }
}

template <class T, class Base>
void PackStepper<T, Base>::normalise(const Tree& tree, T* q, const bool* lanes) noexcept {
  for (const int b : tree.joints_with().quaternions) {
    const int nq = coordinates_of(tree, b), at = tree.first_q(b);
    for (int lane = 0; lane < N; ++lane) {
      if (!lanes[lane]) continue;
      double joint_q[7];
      for (int i = 0; i < nq; ++i) joint_q[i] = q[at + i][lane];
      normalise_joint(tree, b, joint_q);
      for (int i = 0; i < nq; ++i) q[at + i].set(lane, joint_q[i]);
    }
  }
}

template <class T, class Base>
void PackStepper<T, Base>::end_step(const Tree& tree, const double* t) noexcept {
  bool all[N];
  for (bool& lane : all) lane = true;
  normalise(tree, q_.get(), all);
  for (const int b : tree.joints_with().motions)
    for (int lane = 0; lane < N; ++lane) {
      double point[3];
      motion_at(tree, b, t[lane], point);
      q_[tree.first_q(b)].set(lane, point[0]), y_[tree.first_p(b)].set(lane, point[1]);
    }
}

template <class T, class Base>
void PackStepper<T, Base>::step(const Tree& tree, const TopologyPlan& plan, const Block& block) noexcept {
  const int nq = tree.nq(), nv = tree.nv();
  load(tree, block.q, block.y, q0_.get(), y0_.get());
  double t[N];
  begin(tree, plan, block);
  rk4_stages<T>(T::load(block.h), {nq, q0_.get(), workspace_.qdot.get(), q_.get(), q_sum_.get()},
                {nv, y0_.get(), ydot(), y_.get(), y_sum_.get()}, [&](double node, double, const T* q, const T* y) {
                  for (int lane = 0; lane < N; ++lane) t[lane] = block.time[lane] + node * block.h[lane];
                  keeps_ = is_double && (node == 0 || tree.has_constraints());
                  evaluate(tree, plan, block.effort, t, q, y);
                });
  for (int lane = 0; lane < N; ++lane) t[lane] = block.time[lane] + block.h[lane];
  end_step(tree, t);

  using Mask = typename T::Mask;
  Mask plausible = ~Mask{};
  for (int i = 0; i < nq; ++i) plausible &= within(q_[i] - q0_[i], runaway);
  T sum(0);  // 0·x is NaN if x is not finite
  for (int i = 0; i < nv; ++i) sum += 0.0 * y_[i];
  plausible &= within(sum, 0);
  close(tree, block, t, plausible);
  for (int lane = 0; lane < N; ++lane) {
    if (block.h[lane] == 0)
      plausible[lane] = 0;
    else if (plausible[lane] != 0)
      block.time[lane] = t[lane];
    else
      block.diverged[lane] = 1;
  }
  for (int i = 0; i < nq; ++i) select(plausible, q_[i], q0_[i]).store(block.q + i * N);
  for (int i = 0; i < nv; ++i) select(plausible, y_[i], y0_[i]).store(block.y + i * N);
}

}  // namespace momentree::batch
