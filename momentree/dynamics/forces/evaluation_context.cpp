#include <momentree/dynamics/forces/evaluation_context.hpp>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/user_frames.hpp>

namespace momentree {

const LoopValues* EvaluationContext::loop_values(JointId joint) const noexcept {
  const int place = tree_->loops().place(joint);
  if (place < 0) return nullptr;
  LoopValues& values = workspace_->loops->values[static_cast<std::size_t>(place)];
  held_loop_coordinates(*tree_, *workspace_, place, values.q, values.v);
  return &values;
}

Numbers EvaluationContext::q(JointId joint) const noexcept {
  if (is_loop(joint)) {
    const LoopValues* const values = loop_values(joint);
    if (values == nullptr) return {};
    return Numbers(values->q, static_cast<std::size_t>(info(tree_->loops().find(joint)->joint.kind).nq));
  }
  const int b = tree_->carrier(joint.index);
  if (b < 0) return {};
  return Numbers(q_ + tree_->first_q(b), static_cast<std::size_t>(info(tree_->joint(b).kind).nq));
}

Numbers EvaluationContext::v(JointId joint) const noexcept {
  if (is_loop(joint)) {
    const LoopValues* const values = loop_values(joint);
    if (values == nullptr) return {};
    return Numbers(values->v, static_cast<std::size_t>(info(tree_->loops().find(joint)->joint.kind).nv));
  }
  const int b = tree_->carrier(joint.index);
  if (b < 0) return {};
  return Numbers(workspace_->v.get() + tree_->first_p(b), static_cast<std::size_t>(info(tree_->joint(b).kind).nv));
}

bool EvaluationContext::has_function(JointId joint) const noexcept {
  if (is_loop(joint)) {
    const Loop* const loop = tree_->loops().find(joint);
    return loop != nullptr && tree_->function(loop->joint) != nullptr;
  }
  const int b = tree_->carrier(joint.index);
  return b >= 0 && tree_->function(b) != nullptr;
}

BodyMotion EvaluationContext::motion(BodyId body) const noexcept {
  MT_REQUIRE(body.index >= ground.index && body.index < tree_->bodies(), "the world has or had a body of that number");
  if (body == ground || !tree_->alive(body.index)) return {};
  if (!located_) locate_stage(*tree_, q_, *workspace_);
  located_ = true;
  return user_motion(*tree_, workspace_->bodies[static_cast<std::size_t>(body.index)], body.index);
}

}  // namespace momentree
