#pragma once
// Steps in lanes; included only by instantiate/*.cpp, each for one instruction set and precision. No function here may also occur
// in other source files unless its name contains the pack (ADR 9; tools/check_lane_symbols).
#include <momentree/batch/stepper.hpp>
#include <momentree/dynamics/derived_sweep.ipp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/integrate/rk4_stages.hpp>

namespace momentree::batch {

template <class T>
class PackStepper final : public Stepper {
 public:
  explicit PackStepper(const Tree& tree)
      : workspace_(tree),
        q0_(make(7 * tree.bodies())),
        p0_(make(6 * tree.bodies())),
        q_(make(7 * tree.bodies())),
        p_(make(6 * tree.bodies())),
        q_sum_(make(7 * tree.bodies())),
        p_sum_(make(6 * tree.bodies())) {}
  int lanes() const override { return N; }
  void step(const Tree& tree, const ForcePlan& plan, const Block& block) noexcept override;
  void rates(const Tree& tree, const double* q, const double* p, double* qdot, double* pdot, double* v) noexcept override;

 private:
  static constexpr int N = T::lanes;
  using Array = std::unique_ptr<T[]>;
  static Array make(int n) { return std::make_unique_for_overwrite<T[]>(static_cast<std::size_t>(n > 0 ? n : 1)); }

  void evaluate(const Tree& tree, const ForcePlan& plan, const double* effort, const double* t, const T* q, const T* p) noexcept;
  void add_elements(const Tree& tree, int b, const double* t, const T* q) noexcept;
  void end_step(const Tree& tree, const double* t) noexcept;

  Workspace<T> workspace_;
  Array q0_, p0_, q_, p_, q_sum_, p_sum_;
};

template <class T>
void PackStepper<T>::rates(const Tree& tree, const double* q, const double* p, double* qdot, double* pdot, double* v) noexcept {
  const int nq = tree.nq(), nv = tree.nv();
  for (int i = 0; i < nq; ++i) q_[i] = T::load(q + i * N);
  for (int i = 0; i < nv; ++i) p_[i] = T::load(p + i * N);
  evaluate_rates<T>(tree, q_.get(), p_.get(), workspace_);
  for (int i = 0; i < nq; ++i) workspace_.qdot[i].store(qdot + i * N);
  for (int i = 0; i < nv; ++i) workspace_.pdot[i].store(pdot + i * N), workspace_.v[i].store(v + i * N);
}

// Adds the other forces in one joint, lane by lane.
template <class T>
void PackStepper<T>::add_elements(const Tree& tree, int b, const double* t, const T* q) noexcept {
  const int nq = coordinates_of(tree, b), nv = dofs_of(tree, b), at = tree.first_p(b);
  for (int lane = 0; lane < N; ++lane) {
    double joint_q[7], u[6], force[6] = {};
    for (int i = 0; i < nq; ++i) joint_q[i] = q[tree.first_q(b) + i][lane];
    for (int i = 0; i < nv; ++i) u[i] = workspace_.v[at + i][lane];
    add_element_forces(tree, b, t[lane], joint_q, u, force);
    for (int i = 0; i < nv; ++i) workspace_.pdot[at + i].set(lane, workspace_.pdot[at + i][lane] + force[i]);
  }
}

// Rates with the joint forces; t by lane.
template <class T>
void PackStepper<T>::evaluate(const Tree& tree, const ForcePlan& plan, const double* effort, const double* t, const T* q,
                              const T* p) noexcept {
  evaluate_rates<T>(tree, q, p, workspace_);
  const int nv = tree.nv();
  T* const pdot = workspace_.pdot.get();
  const T* const v = workspace_.v.get();
  if (tree.has_forces())
    for (int i = 0; i < nv; ++i) pdot[i] += tree.effort()[i] - tree.damping()[i] * v[i];
  if (effort != nullptr)
    for (int i = 0; i < nv; ++i) pdot[i] += T::load(effort + i * N);
  for (const forces::LinearSpring& s : plan.springs) pdot[s.p] -= s.stiffness * (q[s.q] - s.rest);
  for (const int b : plan.elements) add_elements(tree, b, t, q);
  for (const int b : tree.driven_joints())
    for (int lane = 0; lane < N; ++lane) {
      double point[3];
      motion_at(tree, b, t[lane], point);
      pdot[tree.first_p(b)].set(lane, point[2]);
    }
}

template <class T>
void PackStepper<T>::end_step(const Tree& tree, const double* t) noexcept {
  for (const int b : tree.quaternion_joints()) {
    const int nq = coordinates_of(tree, b), at = tree.first_q(b);
    for (int lane = 0; lane < N; ++lane) {
      double joint_q[7];
      for (int i = 0; i < nq; ++i) joint_q[i] = q_[at + i][lane];
      normalise_joint(tree, b, joint_q);
      for (int i = 0; i < nq; ++i) q_[at + i].set(lane, joint_q[i]);
    }
  }
  for (const int b : tree.driven_joints())
    for (int lane = 0; lane < N; ++lane) {
      double point[3];
      motion_at(tree, b, t[lane], point);
      q_[tree.first_q(b)].set(lane, point[0]), p_[tree.first_p(b)].set(lane, point[1]);
    }
}

template <class T>
void PackStepper<T>::step(const Tree& tree, const ForcePlan& plan, const Block& block) noexcept {
  const int nq = tree.nq(), nv = tree.nv();
  for (int i = 0; i < nq; ++i) q0_[i] = T::load(block.q + i * N);
  for (int i = 0; i < nv; ++i) p0_[i] = T::load(block.p + i * N);
  double t[N];
  rk4_stages<T>(T::load(block.h), {nq, q0_.get(), workspace_.qdot.get(), q_.get(), q_sum_.get()},
                {nv, p0_.get(), workspace_.pdot.get(), p_.get(), p_sum_.get()}, [&](double node, double, const T* q, const T* p) {
                  for (int lane = 0; lane < N; ++lane) t[lane] = block.time[lane] + node * block.h[lane];
                  evaluate(tree, plan, block.effort, t, q, p);
                });
  for (int lane = 0; lane < N; ++lane) t[lane] = block.time[lane] + block.h[lane];
  end_step(tree, t);

  using Mask = typename T::Mask;
  Mask plausible = ~Mask{};
  for (int i = 0; i < nq; ++i) plausible &= within(q_[i] - q0_[i], runaway);
  T sum(0);  // 0·x is NaN if x is not finite
  for (int i = 0; i < nv; ++i) sum += 0.0 * p_[i];
  plausible &= within(sum, 0);
  for (int lane = 0; lane < N; ++lane) {
    if (block.h[lane] == 0)
      plausible[lane] = 0;
    else if (plausible[lane] != 0)
      block.time[lane] = t[lane];
    else
      block.ran_away[lane] = 1;
  }
  for (int i = 0; i < nq; ++i) select(plausible, q_[i], q0_[i]).store(block.q + i * N);
  for (int i = 0; i < nv; ++i) select(plausible, p_[i], p0_[i]).store(block.p + i * N);
}

}  // namespace momentree::batch
