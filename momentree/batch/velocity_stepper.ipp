#pragma once
// Steps of states in velocities, in lanes; included only by instantiate/*.cpp.
#include <momentree/batch/stepper.ipp>
#include <momentree/dynamics/steps/generic_steps.ipp>
#include <momentree/dynamics/velocity.ipp>

namespace momentree::batch {

template <class T>
class PackVelocityStepper final : public PackStepper<T> {
 public:
  /// `width`: of the machine code for lanes like these.
  PackVelocityStepper(const Tree& tree, StepWidth width) : PackStepper<T>(tree), width_(width) {}
  PlanScalars scalars() const override {
    return {step_scalar<T, Passes::stage_velocities>(width_),
            this->is_double ? step_scalar<T, Passes::velocities>(width_) : StepScalar{}};
  }
  void rates(const Tree& tree, const TopologyPlan& plan, const double* q, const double* u, double* qdot, double* udot,
             double* v) noexcept override {
    this->load(tree, q, u, this->q_.get(), this->y_.get());
    this->workspace_.steps = plan.steps.get();
    evaluate_with<false>(tree, this->q_.get(), this->y_.get(), [](T*) {});
    this->store(tree.nq(), this->workspace_.qdot.get(), qdot);
    this->store(tree.nv(), this->workspace_.a.get(), udot);
    this->store(tree.nv(), this->workspace_.v.get(), v);
  }

 private:
  // add_forces(τ) adds the joint forces.
  template <bool Keep, class Forces>
  void evaluate_with(const Tree& tree, const T* q, const T* u, const Forces& add_forces) noexcept {
    const Vec3& g = tree.gravity();
    T* const tau = this->workspace_.a.get();
    sweep_velocities<T, Keep>(tree, q, u, this->workspace_);
    for (int i = 0; i < tree.nv(); ++i) tau[i] = T(0);
    add_forces(tau);
    solve_accelerations<T, Keep>(tree, q, this->workspace_, {{T(-g.x), T(-g.y), T(-g.z)}, {T(0), T(0), T(0)}});
  }
  void evaluate(const Tree& tree, const TopologyPlan& plan, const double* effort, const double* t, const T* q,
                const T* u) noexcept override {
    this->workspace_.steps = plan.steps.get(), this->workspace_.kept_steps = plan.kept_steps.get();
    const auto forces = [&](T* tau) { this->add_forces(tree, plan, effort, t, q, tau); };
    if (this->keeps_)
      evaluate_with<true>(tree, q, u, forces);
    else
      evaluate_with<false>(tree, q, u, forces);
  }
  const T* ydot() const noexcept override { return this->workspace_.a.get(); }

  StepWidth width_;
};

}  // namespace momentree::batch
