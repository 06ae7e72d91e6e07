#include <momentree/dynamics/moment.hpp>

#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/forward.hpp>

namespace momentree {

namespace {
int carrier(const Tree& tree, Body joint) {
  return joint.index >= 0 && joint.index < tree.bodies() ? tree.carrier(joint.index) : -1;
}
}  // namespace

std::span<const double> Moment::q(Body joint) const noexcept {
  const int b = carrier(*tree_, joint);
  if (b < 0) return {};
  return {q_ + tree_->first_q(b), static_cast<std::size_t>(info(tree_->joint(b).kind).nq)};
}

std::span<const double> Moment::v(Body joint) const noexcept {
  const int b = carrier(*tree_, joint);
  if (b < 0) return {};
  return {work_->v.get() + tree_->first_p(b), static_cast<std::size_t>(info(tree_->joint(b).kind).nv)};
}

bool Moment::has_function(Body joint) const noexcept {
  const int b = carrier(*tree_, joint);
  return b >= 0 && tree_->function(b) != nullptr;
}

BodyMotion Moment::motion(Body body) const noexcept {
  if (body.index < 0 || body.index >= tree_->bodies() || !tree_->alive(body.index)) return {};
  if (!located_) locate_stage(*tree_, q_, *work_);
  located_ = true;
  return user_motion(*tree_, work_->bodies[static_cast<std::size_t>(body.index)], body.index);
}

}  // namespace momentree
