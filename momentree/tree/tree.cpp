#include <momentree/tree/tree.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {
template <class T>
void reserve(T& list, std::size_t count) {  // grows by halves, so that additions are cheap
  if (list.capacity() < count) list.reserve(std::max(count, list.capacity() + list.capacity() / 2));
}
}  // namespace

// Room for that many bodies, in any topology.
void Tree::resize(int bodies) {
  const std::size_t n = at(bodies);
  for (auto* list : {&parent_, &first_child_, &next_sibling_, &first_q_, &first_p_, &first_angle_, &place_, &joint_of_, &carrier_,
                     &own_parameters_})
    list->resize(n, -1);
  record_.resize(n), reversed_.resize(n), class_.resize(n), special_.resize(n), changed_.resize(n);
  links_.resize(n), joints_.resize(n), frames_.resize(n), masses_.resize(n);
  angle_q_.resize(2 * n), angle_offset_.resize(2 * n), armature_.resize(6 * n), damping_.resize(6 * n), effort_.resize(6 * n);
  for (auto* list : {&order_, &spring_joints_, &quaternion_joints_, &forced_joints_, &driven_joints_, &strength_joints_})
    reserve(*list, n);
  reserve(segments_, n), reserve(flows_, n);
  reserve(parameters_, shared_parameters_ + n), reserve(per_freedom_, shared_parameters_ + n);
  static const std::size_t largest = [] {
    std::size_t scalars = 0;
    for (const KindInfo& k : all_kinds())
      for (std::size_t record : shape(k.kind).record) scalars = std::max(scalars, record);
    return scalars;
  }();
  record_capacity_ = largest * n;
}

// A body with its declared joint, parameters apart.
void Tree::set_body(int b, const BodySpec& s) {
  parent_[at(b)] = s.parent.index;
  joint_of_[at(b)] = carrier_[at(b)] = b;
  joints_[at(b)] = {s.joint.kind, -1, s.at, s.child_at, s.joint.axis, s.joint.axis2, s.joint.pitch};
  masses_[at(b)] = {s.mass, s.com, s.inertia};
}

Tree::Tree(const Model& model) : gravity_(model.gravity()) {
  if (!model.forces().empty()) forces_ = std::make_shared<const std::vector<BodyForce>>(model.forces());
  resize(model.size());
  for (int b = 0; b < model.size(); ++b) {
    set_body(b, model[{b}]);
    const JointParameters& p = model[{b}].joint.parameters;
    if (!p.any()) continue;
    if (parameters_.empty() || !(parameters_.back() == p)) {
      parameters_.push_back(p);
      per_freedom_.push_back(spread(p));
    }
    joints_[at(b)].parameters = static_cast<int>(parameters_.size()) - 1;
  }
  declared_ = std::make_shared<const std::vector<Joint>>(joints_);
  shared_parameters_ = parameters_.size();
  resize(model.size());  // each joint may get parameters of its own
  link_all();
}

Topology Tree::topology() const {
  Topology t;
  t.places.resize(parent_.size());
  for (int b = 0; b < bodies(); ++b) t.places[at(b)] = {parent_[at(b)], joint_of_[at(b)], reversed_[at(b)] != 0};
  for (int j = 0; j < bodies(); ++j)
    if (changed_[at(j)] != 0 && carrier_[at(j)] >= 0) t.changed.push_back({j, joints_[at(j)]});
  t.own.resize(parameters_.size() - shared_parameters_);
  for (int j = 0; j < bodies(); ++j)
    if (own_parameters_[at(j)] >= 0)
      t.own[at(own_parameters_[at(j)]) - shared_parameters_] = {j, parameters_[at(own_parameters_[at(j)])]};
  t.functions = functions_;
  t.loads = body_functions_;
  t.added.assign(masses_.begin() + static_cast<std::ptrdiff_t>(declared_->size()), masses_.end());
  return t;
}

void Tree::restore(const Topology& topology) {
  MT_REQUIRE(topology.places.size() == declared_->size() + topology.added.size(), "the topology is one of this tree's model");
  resize(static_cast<int>(topology.places.size()));
  std::copy(topology.added.begin(), topology.added.end(), masses_.begin() + static_cast<std::ptrdiff_t>(declared_->size()));
  for (std::size_t j = 0; j < declared_->size(); ++j)
    if (changed_[j] != 0) joints_[j] = (*declared_)[j], changed_[j] = 0;
  for (int& carrier : carrier_) carrier = -1;
  for (int b = 0; b < bodies(); ++b) {
    const Topology::Place& place = topology.places[at(b)];
    parent_[at(b)] = place.parent, joint_of_[at(b)] = place.joint, reversed_[at(b)] = place.reversed ? 1 : 0;
    if (place.joint >= 0) carrier_[at(place.joint)] = b;
  }
  for (const Topology::Changed& c : topology.changed) joints_[at(c.joint)] = c.as, changed_[at(c.joint)] = 1;
  parameters_.resize(shared_parameters_), per_freedom_.resize(shared_parameters_);
  for (int& own : own_parameters_) own = -1;
  for (const Topology::Own& own : topology.own) give_parameters(own.joint, own.parameters);
  functions_ = topology.functions;
  body_functions_ = topology.loads;
  ++revision_;
  link_all();
}

double Tree::next_bend(double t) const {
  double next = HUGE_VAL;
  const auto look = [&](const std::vector<Signal>& signals) {
    for (const Signal& s : signals) next = std::min(next, s.next_bend(t));
  };
  for (const auto* joints : {&forced_joints_, &driven_joints_}) {
    for (const int b : *joints) {
      const JointParameters* p = parameters(b);
      if (p == nullptr || p->drive == nullptr) continue;
      look(p->drive->effort), look(p->drive->pd.target), look(p->drive->pd.target_speed);
      for (const Curve& c : p->drive->motion) next = std::min(next, c.signal().next_bend(t));
    }
  }
  for (const BodyForce& force : body_forces())
    if (alive(force.body.index))
      for (const auto* signals : {&force.force, &force.torque})
        for (const Signal& s : *signals) next = std::min(next, s.next_bend(t));
  return next;
}

}  // namespace momentree
