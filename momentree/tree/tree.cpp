#include <momentree/tree/tree.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/joint/dispatch.hpp>
#include <momentree/tree/kernel_frame.hpp>
#include <momentree/tree/kernel_run.hpp>

namespace momentree {

// Reserves space for that many bodies, in any topology.
void Tree::resize(int bodies) {
  const std::size_t n = at(bodies);
  for (auto* list : {&parent_, &first_child_, &next_sibling_, &place_, &joint_of_, &carrier_, &joint_at_}) list->resize(n, -1);
  offsets_.resize(n), reversed_.resize(n), class_.resize(n), special_.resize(n), subtree_mass_.resize(n);
  links_.resize(n);
  for (auto* list : {&order_, &spring_joints_, &quaternion_joints_, &forced_joints_, &driven_joints_, &strength_joints_})
    detail::reserve(*list, n);
  detail::reserve(runs_, n), detail::reserve(node_flags_, n);
  detail::reserve(own_joints_, n), detail::reserve(own_parameters_, n), detail::reserve(own_dofs_, n);
  detail::reserve(angle_q_, 2 * n), detail::reserve(angle_offset_, 2 * n);
  for (auto* list : {&armature_, &damping_, &effort_}) detail::reserve(*list, 6 * n);
  static const std::size_t largest = [] {
    std::size_t scalars = 0;
    for (const KindInfo& k : all_kinds())
      for (std::size_t record : shape(k.kind).record) scalars = std::max(scalars, record);
    return scalars;
  }();
  record_capacity_ = largest * n;
}

Tree::Tree() = default;
Tree::Tree(const Tree&) = default;
Tree::Tree(Tree&&) noexcept = default;
Tree& Tree::operator=(const Tree&) = default;
Tree& Tree::operator=(Tree&&) noexcept = default;
Tree::~Tree() = default;

const KernelFrame& Tree::frame(int b) const { return links_.frame(index(b)); }

Tree::Tree(const Model& model) : gravity_(model.gravity()) {
  const std::shared_ptr<detail::Declared> declared = detail::declare(model);
  declared_ = declared;
  resize(model.size());
  for (int b = 0; b < model.size(); ++b) {
    parent_[at(b)] = declared->bodies[at(b)].parent;
    joint_of_[at(b)] = carrier_[at(b)] = b;
    joint_at_[at(b)] = declared->bodies[at(b)].joint;
  }
  put_springs({});
  coupling_ended_.assign(declared->couplings.size(), 0);
  revision_.renew(), loop_revision_.renew();
  for (const LoopSpec& spec : model.loops()) {
    Loop loop;
    loop.number = next_loop_++;
    loop.body = spec.body.index, loop.to = spec.to.index;
    loop.joint = detail::joint_of(spec);
    loop.parameters = spec.joint.parameters;
    loops_.push_back(std::move(loop));
  }
  detail::LinkCollector links(*declared);
  link_all(&links);
  if (links.finish())
    for (int b = 0; b < bodies(); ++b) links_.share(at(b), at(declared->bodies[at(b)].link));
}

Topology Tree::topology() const {
  Topology t;
  t.places.resize(parent_.size());
  for (int b = 0; b < bodies(); ++b) t.places[at(b)] = {parent_[at(b)], joint_of_[at(b)], reversed_[at(b)] != 0};
  t.own.resize(own_parameters_.size());
  for (int j = 0; j < bodies(); ++j) {
    if (joint_at_[at(j)] >= 0) continue;
    const OwnJoint& own = own_joints_[at(~joint_at_[at(j)])];
    if (carrier_[at(j)] >= 0) t.changed.push_back({j, own.joint});
    if (own.parameters >= 0) t.own[at(own.parameters)] = {j, own_parameters_[at(own.parameters)]};
  }
  t.functions = functions_;
  t.loads = body_functions_;
  t.loops = loops_;
  for (const Topology::SpringChange& s : spring_states_)
    if (s.broken || s.law != law_of(springs()[at(s.spring)])) t.springs.push_back(s);
  for (std::size_t c = 0; c < coupling_ended_.size(); ++c)
    if (coupling_ended_[c] != 0) t.ended_couplings.push_back(static_cast<int>(c));
  t.contacts = contacts_;
  t.added = added_masses_;
  t.model = declared_ ? declared_->fingerprint : 0;
  return t;
}

// Checks a topology that was read from elsewhere or taken from another tree.
void Tree::require_valid(const Topology& topology) const {
  const int declared = static_cast<int>(declared_bodies()), all = static_cast<int>(topology.places.size());
  MT_REQUIRE(topology.model == (declared_ ? declared_->fingerprint : 0) && at(all) == at(declared) + topology.added.size(),
             "the topology is of a tree that was compiled from the same model");
  const auto has = [all](int number) { return number >= 0 && number < all; };
  for (const Topology::Changed& c : topology.changed) {
    MT_REQUIRE(has(c.joint), "a changed joint is one of the topology's");
    const int parameters = c.as.parameters - shared_parameters(), function = c.as.function;
    MT_REQUIRE(parameters < static_cast<int>(topology.own.size()), "a changed joint's parameters exist");
    MT_REQUIRE(function < static_cast<int>(topology.functions.size()), "a changed joint's function exists");
    MT_REQUIRE(c.as.locked >> info(c.as.kind).nv == 0, "a joint's locked degrees of freedom are those of its kind");
  }
  for (const Topology::Place& place : topology.places) {
    if (place.joint < 0) continue;
    MT_REQUIRE(has(place.joint), "a body carries a joint of the topology");
    MT_REQUIRE(place.parent == -1 || (has(place.parent) && topology.places[at(place.parent)].joint >= 0),
               "a parent is the ground or a body of the topology");
    MT_REQUIRE(!place.reversed || place.parent >= 0, "the ground is not a joint's child");
  }
  for (const Topology::Own& own : topology.own) MT_REQUIRE(has(own.joint), "parameters are those of a joint of the topology");
  for (const auto& function : topology.functions) MT_REQUIRE(function != nullptr, "a function is not null");
  for (const Topology::SpringChange& s : topology.springs)
    MT_REQUIRE(s.spring >= 0 && at(s.spring) < springs().size(), "a changed spring is one of the model's");
  for (const int c : topology.ended_couplings)
    MT_REQUIRE(c >= 0 && at(c) < couplings().size(), "a coupling that ended is one of the model's");
  for (const Topology::Loaded& load : topology.loads)
    MT_REQUIRE(has(load.body) && load.function != nullptr, "a function acts on a body of the topology");
}

void Tree::restore(const Topology& topology) {
  const std::size_t declared = declared_bodies();
  require_valid(topology);
  resize(static_cast<int>(topology.places.size()));
  added_masses_ = topology.added;
  own_joints_.clear(), own_parameters_.clear(), own_dofs_.clear();
  std::fill(carrier_.begin(), carrier_.end(), -1);
  for (int b = 0; b < bodies(); ++b) {
    const Topology::Place& place = topology.places[at(b)];
    parent_[at(b)] = place.parent, joint_of_[at(b)] = place.joint, reversed_[at(b)] = place.reversed ? 1 : 0;
    if (place.joint >= 0) {
      MT_REQUIRE(carrier_[at(place.joint)] < 0, "each joint is carried by one body");
      carrier_[at(place.joint)] = b;
    }
    joint_at_[at(b)] = at(b) < declared ? declared_->bodies[at(b)].joint : no_joint;
  }
  for (const Topology::Changed& c : topology.changed) own_joint(c.joint).joint = c.as;
  for (int j = static_cast<int>(declared); j < bodies(); ++j)
    MT_REQUIRE(carrier_[at(j)] < 0 || joint_at_[at(j)] != no_joint, "a joint that the model does not have is given");
  for (const Topology::Own& own : topology.own) give_parameters(own.joint, own.parameters);
  functions_ = topology.functions;
  body_functions_ = topology.loads;
  loops_ = topology.loops;
  for (const Loop& loop : loops_) next_loop_ = std::max(next_loop_, loop.number + 1);
  contacts_ = topology.contacts;
  loop_links_.clear(), loop_stops_.clear();
  loop_rows_ = loop_columns_ = loop_motions_ = loop_armatures_ = loop_functions_ = 0;
  note_constraints();
  put_springs(topology.springs);
  std::fill(coupling_ended_.begin(), coupling_ended_.end(), static_cast<unsigned char>(0));
  for (const int c : topology.ended_couplings) coupling_ended_[at(c)] = 1;
  revision_.renew(), loop_revision_.renew();
  link_all();
}

const MassProperties& Tree::mass(int b) const {
  const std::size_t declared = declared_bodies();
  return at(b) < declared ? declared_->masses[at(declared_->bodies[at(b)].mass)] : added_masses_[at(b) - declared];
}

template <class Look>
void Tree::for_signals(Look look) const {
  const auto look_at = [&](const JointDrive* drive) {
    if (drive == nullptr) return;
    for (const auto* signals : {&drive->effort, &drive->pd.target, &drive->pd.target_speed})
      for (const Signal& s : *signals) look(s);
    for (const Curve& c : drive->motion) look(c.signal());
  };
  for (const auto* joints : {&forced_joints_, &driven_joints_})
    for (const int b : *joints)
      if (const JointParameters* p = parameters(b)) look_at(p->drive.get());
  for (const Loop& loop : loops_) look_at(loop.parameters.drive.get());
  for (const BodyForce& force : body_forces())
    if (alive(force.body.index))
      for (const auto* signals : {&force.force, &force.torque})
        for (const Signal& s : *signals) look(s);
}

double Tree::next_bend(double t) const {
  double next = HUGE_VAL;
  for_signals([&](const Signal& s) { next = std::min(next, s.next_bend(t)); });
  return next;
}

double Tree::shortest_period() const {
  double shortest = HUGE_VAL;
  for_signals([&](const Signal& s) {
    if (s.amplitude() != 0 && s.frequency() != 0) shortest = std::min(shortest, 1 / std::fabs(s.frequency()));
  });
  return shortest;
}

}  // namespace momentree
