#pragma once
// Steps of states in momenta, in lanes; included only by instantiate/*.cpp.
#include <momentree/batch/stepper.ipp>
#include <momentree/dynamics/derived_sweep.ipp>

namespace momentree::batch {

template <class T>
class PackMomentaStepper final : public PackStepper<T> {
 public:
  explicit PackMomentaStepper(const Tree& tree) : PackStepper<T>(tree) {}
  void rates(const Tree& tree, const double* q, const double* p, double* qdot, double* pdot, double* v) noexcept override {
    this->load(tree, q, p, this->q_.get(), this->y_.get());
    evaluate_rates<T>(tree, this->q_.get(), this->y_.get(), this->workspace_);
    this->store(tree.nq(), this->workspace_.qdot.get(), qdot);
    this->store(tree.nv(), this->workspace_.pdot.get(), pdot);
    this->store(tree.nv(), this->workspace_.v.get(), v);
  }

 private:
  void evaluate(const Tree& tree, const ForcePlan& plan, const double* effort, const double* t, const T* q,
                const T* p) noexcept override {
    evaluate_rates<T>(tree, q, p, this->workspace_);
    this->add_forces(tree, plan, effort, t, q, this->workspace_.pdot.get());
  }
  const T* ydot() const noexcept override { return this->workspace_.pdot.get(); }
};

}  // namespace momentree::batch
