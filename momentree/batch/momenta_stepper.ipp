#pragma once
// Steps of states in momenta, in lanes; included only by instantiate/*.cpp.
#include <momentree/batch/stepper.ipp>
#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/steps/generic_steps.ipp>

namespace momentree::batch {

template <class T>
class PackMomentaStepper final : public PackStepper<T> {
 public:
  /// `width`: of the machine code for lanes like these.
  PackMomentaStepper(const Tree& tree, StepWidth width) : PackStepper<T>(tree), width_(width) {}
  PlanScalars scalars() const override {
    return {step_scalar<T, Passes::stage_momenta>(width_),
            this->is_double ? step_scalar<T, Passes::momenta>(width_) : StepScalar{}};
  }
  void rates(const Tree& tree, const TopologyPlan& plan, const double* q, const double* p, double* qdot, double* pdot,
             double* v) noexcept override {
    this->load(tree, q, p, this->q_.get(), this->y_.get());
    this->workspace_.steps = plan.steps.get();
    evaluate_rates<T>(tree, this->q_.get(), this->y_.get(), this->workspace_);
    this->store(tree.nq(), this->workspace_.qdot.get(), qdot);
    this->store(tree.nv(), this->workspace_.pdot.get(), pdot);
    this->store(tree.nv(), this->workspace_.v.get(), v);
  }

 private:
  void evaluate(const Tree& tree, const TopologyPlan& plan, const double* effort, const double* t, const T* q,
                const T* p) noexcept override {
    this->workspace_.steps = plan.steps.get(), this->workspace_.kept_steps = plan.kept_steps.get();
    if (this->keeps_)
      evaluate_motions<T>(tree, q, p, this->workspace_);
    else
      evaluate_rates<T>(tree, q, p, this->workspace_);
    T *const pdot = this->workspace_.pdot.get(), *const force = this->workspace_.a.get();
    if (!tree.has_constraints()) return this->add_forces(tree, plan, effort, t, q, pdot);
    for (int i = 0; i < tree.nv(); ++i) force[i] = T(0);  // summed first, as simulations with prescribed motions do
    this->add_forces(tree, plan, effort, t, q, force);
    for (int i = 0; i < tree.nv(); ++i) pdot[i] += force[i];
  }
  const T* ydot() const noexcept override { return this->workspace_.pdot.get(); }

  StepWidth width_;
};

}  // namespace momentree::batch
