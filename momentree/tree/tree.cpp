#include <momentree/tree/tree.hpp>

#include <algorithm>

#include <momentree/base/check.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

Tree::Tree(const Model& model) : gravity_(model.gravity()) {
  const int n = model.size();
  const auto size = at(n);
  parent_.resize(size), first_child_.assign(size, -1), next_sibling_.assign(size, -1);
  first_q_.resize(size), first_p_.resize(size), first_angle_.resize(size), order_.resize(size), place_.resize(size);
  record_.resize(size), reversed_.assign(size, 0), class_.resize(size), special_.resize(size);
  joint_of_.resize(size), carrier_.resize(size);
  for (int b = 0; b < n; ++b) joint_of_[at(b)] = carrier_[at(b)] = b;
  links_.resize(size), joints_.resize(size), frames_.resize(size), masses_.resize(size);
  segments_.reserve(size), spring_joints_.reserve(size), quaternion_joints_.reserve(size);
  angle_q_.resize(2 * size), angle_offset_.resize(2 * size), armature_.resize(6 * size), damping_.resize(6 * size),
      effort_.resize(6 * size);
  std::size_t largest = 0;
  for (const KindInfo& k : all_kinds())
    for (std::size_t record : shape(k.kind).record) largest = std::max(largest, record);
  record_capacity_ = largest * size;

  for (int b = 0; b < n; ++b) {
    const BodySpec& s = model.bodies()[at(b)];
    parent_[at(b)] = s.parent.index;
    joints_[at(b)] = {s.joint.kind, -1, s.at, s.child_at, s.joint.axis, s.joint.axis2, s.joint.pitch};
    masses_[at(b)] = {s.mass, s.com, s.inertia};
    const JointParameters& p = s.joint.parameters;
    if (p.damping.any() || p.stiffness.any() || p.armature.any() || p.effort.any() || !p.rest.empty() || p.limits.any()) {
      if (parameters_.empty() || !(parameters_.back() == p)) {
        parameters_.push_back(p);
        per_freedom_.push_back(spread(p));
      }
      joints_[at(b)].parameters = static_cast<int>(parameters_.size()) - 1;
    }
  }
  declared_ = std::make_shared<const std::vector<Joint>>(joints_);
  changed_.assign(size, 0);
  shared_parameters_ = parameters_.size();
  own_parameters_.assign(size, -1);
  parameters_.reserve(parameters_.size() + size), per_freedom_.reserve(parameters_.size() + size);
  link_all();
}

Topology Tree::topology() const {
  Topology t;
  t.places.resize(parent_.size());
  for (int b = 0; b < bodies(); ++b) t.places[at(b)] = {parent_[at(b)], joint_of_[at(b)], reversed_[at(b)] != 0};
  for (int j = 0; j < bodies(); ++j)
    if (changed_[at(j)] != 0) t.changed.push_back({j, joints_[at(j)]});
  t.own.resize(parameters_.size() - shared_parameters_);
  for (int j = 0; j < bodies(); ++j)
    if (own_parameters_[at(j)] >= 0)
      t.own[at(own_parameters_[at(j)]) - shared_parameters_] = {j, parameters_[at(own_parameters_[at(j)])]};
  return t;
}

void Tree::restore(const Topology& topology) {
  MT_REQUIRE(topology.places.size() == parent_.size(), "the topology is one of this tree's model");
  for (int j = 0; j < bodies(); ++j)
    if (changed_[at(j)] != 0) joints_[at(j)] = (*declared_)[at(j)], changed_[at(j)] = 0;
  for (int b = 0; b < bodies(); ++b) {
    const Topology::Place& place = topology.places[at(b)];
    parent_[at(b)] = place.parent;
    joint_of_[at(b)] = place.joint, carrier_[at(place.joint)] = b;
    reversed_[at(b)] = place.reversed ? 1 : 0;
  }
  for (const Topology::Changed& c : topology.changed) joints_[at(c.joint)] = c.as, changed_[at(c.joint)] = 1;
  parameters_.resize(shared_parameters_), per_freedom_.resize(shared_parameters_);
  for (int& own : own_parameters_) own = -1;
  for (const Topology::Own& own : topology.own) give_parameters(own.joint, own.parameters);
  ++revision_;
  link_all();
}

}  // namespace momentree
