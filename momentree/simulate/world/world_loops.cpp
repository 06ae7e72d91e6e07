// Loop joints of a world.
#include <algorithm>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

std::vector<JointId> World::loops() const {
  std::vector<JointId> all;
  for (const Loop& loop : tree_.loops()) all.push_back(loop.id());
  return all;
}

LoopStatus World::loop_status() const { return momentree::loop_status(tree_, state_, workspace_); }

JointView World::loop_view(JointId number) const {
  const int place = tree_.loops().place(number);
  MT_REQUIRE(place >= 0, "the joint is in this world");
  const auto i = static_cast<std::size_t>(place);
  evaluate();
  const Loop& loop = tree_.loops()[i];
  const KindInfo& kind = info(loop.joint.kind);
  if (loop_values_.size() < tree_.loops().size()) loop_values_.resize(tree_.loops().size());
  LoopValues& own = loop_values_[i];
  held_loop_coordinates(tree_, workspace_, place, own.q, own.v);
  JointView view;
  view.name = joint_name(number);
  view.kind = loop.joint.kind;
  view.child = {loop.body}, view.parent = {loop.to};
  view.locked = loop.joint.locked & ~constraints_.held(number.index), view.resting = constraints_.held(number.index);
  view.at = loop.joint.at, view.child_at = loop.joint.child_at;
  view.axis = loop.joint.axis, view.axis2 = loop.joint.axis2, view.pitch = loop.joint.pitch;
  view.parameters = &loop.parameters;
  view.q = {own.q, static_cast<std::size_t>(kind.nq)};
  view.v = {own.v, static_cast<std::size_t>(kind.nv)};
  view.loop = true;
  view.driven = loop.driven();
  return view;
}

JointForces World::loop_forces(JointId number) const {
  const int i = tree_.loops().place(number);
  MT_REQUIRE(i >= 0, "the joint is in this world");
  accelerate(tree_, state_, workspace_);
  const Loop& loop = tree_.loops()[static_cast<std::size_t>(i)];
  const LoopReaction found = loop_reaction(tree_, state_.time(), workspace_, i);
  const auto wrench = [&](const Wrench& W) {
    const Force<double> on_child = to_user_frame(tree_.frame(loop.body), as_force(W));
    return Wrench{on_child.l, on_child.h - cross(loop.joint.child_at.position, on_child.l)};
  };
  JointForces forces;
  forces.reaction = wrench(found.total), forces.bearing = wrench(found.constraint);
  for (int k = 0; k < info(loop.joint.kind).nv; ++k) forces.effort.push_back(found.effort[k]);
  return forces;
}

}  // namespace momentree
