#include <momentree/simulate/world.hpp>

#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/dynamics/momentum.hpp>

namespace momentree {

World::World(const Model& model) : model_(model) {
  const std::vector<SingularJoint> singular = singular_joints(model_);
  if (!singular.empty()) {
    const BodySpec& body = model_[singular.front().body];
    fail({singular.front().what, "joint '" + body.joint_name + "'", singular.front().hint});
  }
  mechanism_names_.resize(static_cast<std::size_t>(model_.size()));
  for (int b = 0; b < model_.size(); ++b)
    if (model_.bodies()[static_cast<std::size_t>(b)].parent == ground)
      mechanism_names_[static_cast<std::size_t>(b)] = model_.mechanism_name({b});
  restore(0, {}, {});
}

void World::restore(double time, std::span<const Body> broken, std::span<const JointStart> joints) {
  tree_ = Tree(model_);
  for (const Body b : broken) tree_.detach(b.index);
  State state(tree_);
  work_ = Work<double>(tree_);
  motions_.resize(static_cast<std::size_t>(model_.size()));
  motions_of_ = {};

  std::vector<double> v(static_cast<std::size_t>(tree_.nv()));
  const State::Edit edit = state.edit();
  edit.time = time;
  const auto put = [](const Values& from, int at, std::span<double> to) {
    for (int i = 0; i < from.size(); ++i) to[static_cast<std::size_t>(at + i)] = from[i];
  };
  for (int b = 0; b < model_.size(); ++b) {
    if (tree_.detached(b)) continue;
    put(model_[{b}].q, tree_.first_q(b), edit.q);
    put(model_[{b}].v, tree_.first_p(b), v);
  }
  for (const JointStart& j : joints) {
    put(j.q, tree_.first_q(j.child.index), edit.q);
    put(j.v, tree_.first_p(j.child.index), v);
  }
  project_momentum(tree_, state.q().data(), v.data(), edit.p.data());
  for (const JointStart& j : joints) put(j.p, tree_.first_p(j.child.index), edit.p);
  state_ = state;
}

void World::evaluate() const { forward_dynamics(tree_, state_, work_); }

const std::vector<BodyMotion>& World::motions() const {
  if (motions_of_ == state_.stamp()) return motions_;
  locate_bodies(tree_, state_, work_);
  for (int b = 0; b < tree_.bodies(); ++b) {
    const auto i = static_cast<std::size_t>(b);
    const Kinematics<double>& k = work_.bodies[i];
    BodyMotion& m = motions_[i];
    m.pose = user_pose(tree_, k, b);
    m.angular = k.R * k.velocity.w;
    m.linear = k.R * k.velocity.v + cross(m.angular, m.pose.position - k.r);
  }
  motions_of_ = state_.stamp();
  return motions_;
}

std::string_view World::joint_name(Body child) const {
  return tree_.detached(child.index) ? model_[child].name : model_[child].joint_name;
}

std::string_view World::mechanism_name(Body root) const {
  const std::string& name = mechanism_names_[static_cast<std::size_t>(root.index)];
  return name.empty() ? model_[root].name : name;
}

JointView World::joint(Body child) const {
  evaluate();
  const int b = child.index;
  const Joint& j = tree_.joint(b);
  const KindInfo& kind = info(j.kind);
  const auto nq = static_cast<std::size_t>(kind.nq), nv = static_cast<std::size_t>(kind.nv);
  return {joint_name(child),
          j.kind,
          child,
          {tree_.parent(b)},
          j.at,
          j.child_at,
          j.axis,
          j.axis2,
          j.pitch,
          tree_.parameters(b),
          state_.q().subspan(static_cast<std::size_t>(tree_.first_q(b)), nq),
          {work_.v.get() + tree_.first_p(b), nv},
          state_.p().subspan(static_cast<std::size_t>(tree_.first_p(b)), nv),
          {work_.pdot.get() + tree_.first_p(b), nv}};
}

Totals World::totals() const { return momentree::totals(tree_, state_, work_); }

std::vector<Mechanism> World::mechanisms() const {
  std::vector<Mechanism> all;
  for (int b : tree_.order()) {
    if (tree_.parent(b) < 0) all.push_back({mechanism_name({b}), {b}, tree_.joint(b).kind != Kind::free, {}});
    all.back().bodies.push_back({b});
  }
  return all;
}

std::vector<std::string> World::mechanism_names() const {
  std::vector<std::string> names;
  for (int b = tree_.first_root(); b >= 0; b = tree_.next_sibling(b)) names.emplace_back(mechanism_name({b}));
  return names;
}

}  // namespace momentree
