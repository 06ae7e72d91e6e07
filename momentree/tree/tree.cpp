#include <momentree/tree/tree.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/joint/dispatch.hpp>
#include <momentree/tree/edit.hpp>
#include <momentree/tree/kernel_frame.hpp>

namespace momentree {

// Reserves space for that many bodies, in any topology.
void Tree::resize(int bodies) {
  const std::size_t n = at(bodies);
  for (auto* list : {&tables_.parent, &first_child_, &next_sibling_, &place_, &joint_of_, &carrier_, &joint_at_})
    list->resize(n, -1);
  tables_.offsets.resize(n), reversed_.resize(n), tables_.classes.resize(n), special_.resize(n), tables_.subtree_mass.resize(n);
  tables_.links.resize(n);
  for (auto* list : {&tables_.order, &special_joints_.springs, &special_joints_.quaternions, &special_joints_.forces,
                     &special_joints_.motions, &special_joints_.strengths})
    detail::reserve(*list, n);
  detail::reserve(tables_.runs, n), detail::reserve(tables_.node_flags, n);
  detail::reserve(own_joints_, n), detail::reserve(own_parameters_, n), detail::reserve(own_dofs_, n);
  detail::reserve(tables_.angle_q, 2 * n), detail::reserve(tables_.angle_offset, 2 * n);
  for (auto* list : {&tables_.armature, &tables_.damping, &tables_.effort}) detail::reserve(*list, 6 * n);
  static const std::size_t largest = [] {
    std::size_t scalars = 0;
    for (const KindInfo& k : all_kinds())
      for (std::size_t record : shape(k.kind).record) scalars = std::max(scalars, record);
    return scalars;
  }();
  tables_.record_capacity = largest * n;
}

Tree::Tree() = default;
Tree::Tree(const Tree&) = default;
Tree::Tree(Tree&&) noexcept = default;
Tree& Tree::operator=(const Tree&) = default;
Tree& Tree::operator=(Tree&&) noexcept = default;
Tree::~Tree() = default;

const KernelFrame& Tree::frame(int b) const { return tables_.links.frame(index(b)); }

Tree::Tree(const Model& model) : gravity_(model.gravity()) {
  const std::shared_ptr<detail::Declared> declared = detail::declare(model);
  declared_ = declared;
  resize(model.size());
  for (int b = 0; b < model.size(); ++b) {
    tables_.parent[at(b)] = declared->bodies[at(b)].parent;
    joint_of_[at(b)] = carrier_[at(b)] = b;
    joint_at_[at(b)] = declared->bodies[at(b)].joint;
  }
  loads_.forces = declared->forces;
  springs_.declared = declared->springs;
  put_springs({});
  coupling_ended_.assign(declared->couplings.size(), 0);
  revision_.renew(), loops_.version.renew();
  for (const LoopSpec& spec : model.loops()) {
    Loop loop;
    loop.number = loops_.next_number++;
    loop.body = spec.body.index, loop.to = spec.to.index;
    loop.joint = detail::joint_of(spec);
    loop.parameters = spec.joint.parameters;
    loops_.joints.push_back(std::move(loop));
  }
  detail::LinkCollector links(*declared);
  link_all(&links);
  if (links.finish())
    for (int b = 0; b < bodies(); ++b) tables_.links.share(at(b), at(declared->bodies[at(b)].link));
}

Topology Tree::topology() const {
  Topology t;
  t.places.resize(tables_.parent.size());
  for (int b = 0; b < bodies(); ++b) t.places[at(b)] = {tables_.parent[at(b)], joint_of_[at(b)], reversed_[at(b)] != 0};
  t.own.resize(own_parameters_.size());
  for (int j = 0; j < bodies(); ++j) {
    if (joint_at_[at(j)] >= 0) continue;
    const OwnJoint& own = own_joints_[at(~joint_at_[at(j)])];
    if (carrier_[at(j)] >= 0) t.changed.push_back({j, own.joint});
    if (own.parameters >= 0) t.own[at(own.parameters)] = {j, own_parameters_[at(own.parameters)]};
  }
  t.functions = functions_;
  t.loads = loads_.functions;
  t.loops = loops_.joints;
  for (const Topology::SpringChange& s : springs_.states)
    if (s.broken || s.law != law_of(springs_[at(s.spring)])) t.springs.push_back(s);
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
    MT_REQUIRE(s.spring >= 0 && at(s.spring) < springs_.size(), "a changed spring is one of the model's");
  for (const int c : topology.ended_couplings)
    MT_REQUIRE(c >= 0 && at(c) < couplings().size(), "a coupling that ended is one of the model's");
  for (const Topology::Loaded& load : topology.loads)
    MT_REQUIRE(has(load.body) && load.function != nullptr, "a function acts on a body of the topology");
}

void Tree::Edit::restore(const Topology& topology) {
  const std::size_t declared = tree_.declared_bodies();
  tree_.require_valid(topology);
  tree_.resize(static_cast<int>(topology.places.size()));
  tree_.added_masses_ = topology.added;
  tree_.own_joints_.clear(), tree_.own_parameters_.clear(), tree_.own_dofs_.clear();
  std::fill(tree_.carrier_.begin(), tree_.carrier_.end(), -1);
  for (int b = 0; b < tree_.bodies(); ++b) {
    const Topology::Place& place = topology.places[at(b)];
    tree_.tables_.parent[at(b)] = place.parent, tree_.joint_of_[at(b)] = place.joint,
    tree_.reversed_[at(b)] = place.reversed ? 1 : 0;
    if (place.joint >= 0) {
      MT_REQUIRE(tree_.carrier_[at(place.joint)] < 0, "each joint is carried by one body");
      tree_.carrier_[at(place.joint)] = b;
    }
    tree_.joint_at_[at(b)] = at(b) < declared ? tree_.declared_->bodies[at(b)].joint : no_joint;
  }
  for (const Topology::Changed& c : topology.changed) tree_.own_joint(c.joint).joint = c.as;
  for (int j = static_cast<int>(declared); j < tree_.bodies(); ++j)
    MT_REQUIRE(tree_.carrier_[at(j)] < 0 || tree_.joint_at_[at(j)] != no_joint, "a joint that the model does not have is given");
  for (const Topology::Own& own : topology.own) tree_.give_parameters(own.joint, own.parameters);
  tree_.functions_ = topology.functions;
  tree_.loads_.functions = topology.loads;
  tree_.loops_.joints = topology.loops;
  for (const Loop& loop : tree_.loops_.joints) tree_.loops_.next_number = std::max(tree_.loops_.next_number, loop.number + 1);
  tree_.contacts_ = topology.contacts;
  tree_.loops_.links.clear(), tree_.loops_.stops.clear();
  tree_.loops_.rows = tree_.loops_.columns = tree_.loops_.motions = tree_.loops_.armatures = tree_.loops_.functions = 0;
  tree_.note_constraints();
  tree_.put_springs(topology.springs);
  std::fill(tree_.coupling_ended_.begin(), tree_.coupling_ended_.end(), static_cast<unsigned char>(0));
  for (const int c : topology.ended_couplings) tree_.coupling_ended_[at(c)] = 1;
  tree_.revision_.renew(), tree_.loops_.version.renew();
  tree_.link_all();
}

const MassProperties& Tree::mass(int b) const {
  const std::size_t declared = declared_bodies();
  return at(b) < declared ? declared_->masses[at(declared_->bodies[at(b)].mass)] : added_masses_[at(b) - declared];
}

}  // namespace momentree
