#include <momentree/batch/group.hpp>

#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/joint/joint.hpp>

namespace momentree::batch {

bool same_pose(const Pose& a, const Pose& b) noexcept {
  const Quat &x = a.rotation, &y = b.rotation;
  return a.position == b.position && x.w == y.w && x.x == y.x && x.y == y.y && x.z == y.z;
}

namespace {

bool same(const Joint& a, const Joint& b) {
  return a.kind == b.kind && a.parameters == b.parameters && same_pose(a.at, b.at) && same_pose(a.child_at, b.child_at) &&
         a.axis == b.axis && a.axis2 == b.axis2 && a.pitch == b.pitch && a.locked == b.locked &&
         a.created_by_event == b.created_by_event && a.function == b.function;
}
bool same(const Sym3& a, const Sym3& b) {
  return a.xx == b.xx && a.yy == b.yy && a.zz == b.zz && a.xy == b.xy && a.xz == b.xz && a.yz == b.yz;
}

constexpr Unsupported functions_unsupported{"batches do not call functions", "set efforts between steps: Batch::set_effort"};

template <class List, class Equal>
bool equal_lists(const List& a, const List& b, Equal equal) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), equal);
}

}  // namespace

bool same(const Topology& a, const Topology& b) noexcept {
  using T = Topology;
  return equal_lists(a.places, b.places,
                     [](const T::Place& x, const T::Place& y) {
                       return x.parent == y.parent && x.joint == y.joint && x.reversed == y.reversed;
                     }) &&
         equal_lists(a.changed, b.changed,
                     [](const T::Changed& x, const T::Changed& y) { return x.joint == y.joint && same(x.as, y.as); }) &&
         equal_lists(a.own, b.own,
                     [](const T::Own& x, const T::Own& y) { return x.joint == y.joint && x.parameters == y.parameters; }) &&
         equal_lists(a.added, b.added,
                     [](const MassProperties& x, const MassProperties& y) {
                       return x.mass == y.mass && x.com == y.com && same(x.inertia, y.inertia);
                     }) &&
         a.functions == b.functions && a.loads.size() == b.loads.size() &&
         equal_lists(a.loops, b.loops,
                     [](const Loop& x, const Loop& y) {
                       return x.number == y.number && x.body == y.body && x.to == y.to && same(x.joint, y.joint) &&
                              x.parameters == y.parameters && x.held == y.held;
                     }) &&
         a.springs == b.springs && a.ended_couplings == b.ended_couplings;
}

void simplify(Topology& topology, const Tree& declared) {
  std::erase_if(topology.changed,
                [&](const Topology::Changed& c) { return c.joint < declared.bodies() && same(c.as, declared.joint(c.joint)); });
}

std::size_t key_of(const Topology& topology) noexcept {
  std::uint64_t key = 14695981039346656037ULL;  // FNV-1a over whole numbers
  const auto mix = [&](std::int64_t number) { key = (key ^ static_cast<std::uint64_t>(number)) * 1099511628211ULL; };
  for (const Topology::Place& p : topology.places) mix(p.parent), mix(2 * p.joint + (p.reversed ? 1 : 0));
  for (const Topology::Changed& c : topology.changed) mix(c.joint), mix(static_cast<int>(c.as.kind)), mix(c.as.locked);
  for (const Topology::Own& own : topology.own) mix(own.joint);
  mix(static_cast<std::int64_t>(topology.added.size()));
  for (const Loop& loop : topology.loops)
    mix(loop.number), mix(loop.body), mix(loop.to), mix(static_cast<int>(loop.joint.kind)), mix(loop.joint.locked);
  for (const Topology::SpringChange& spring : topology.springs) mix(2 * spring.spring + (spring.broken ? 1 : 0));
  for (const int coupling : topology.ended_couplings) mix(coupling);
  return static_cast<std::size_t>(key);
}

std::optional<Unsupported> unsupported(const Tree& tree) noexcept {
  if (!tree.loads().functions.empty() || has_functions(tree)) return functions_unsupported;
  if (!tree.loads().forces.empty())
    return Unsupported{"worlds in lanes have no forces on bodies", "give one to the model: its worlds are stepped one by one"};
  if (tree.springs().count() > 0)
    return Unsupported{"worlds in lanes have no springs between two points",
                       "give one to the model: its worlds are stepped one by one"};
  const TreeLoops& loops = tree.loops();
  const auto any_loop = [&](const auto& has) { return std::any_of(loops.begin(), loops.end(), has); };
  if (!tree.joints_with().strengths.empty() || any_loop([](const Loop& loop) { return loop.parameters.strength.any(); }))
    return Unsupported{"worlds in lanes have no joint strengths",
                       "give a joint of the model one: its worlds are stepped one by one; or apply Break"};
  const auto order = tree.order();
  if (any_loop([](const Loop& loop) { return loop.parameters.limits.hard(); }) ||
      std::any_of(order.begin(), order.end(),
                  [&](int b) { return tree.parameters(b) != nullptr && tree.parameters(b)->limits.hard(); }))
    return Unsupported{"worlds in lanes have no hard stops",
                       "give the limits a stiffness, or a joint of the model a hard stop: its worlds are stepped one by one"};
  return std::nullopt;
}

void check_functions(const Tree& tree) {
  if (!tree.loads().functions.empty() || has_functions(tree))
    throw_error({functions_unsupported.problem, "", functions_unsupported.hint});
}

void check(const Tree& tree) {
  if (const std::optional<Unsupported> why = unsupported(tree)) throw_error({why->problem, "", why->hint});
}

Group::Group(Topology topology, const Tree& tree, int lanes, Variables variables, const PlanScalars& scalars)
    : topology_(std::move(topology)),
      key_(key_of(topology_)),
      tree_(tree),
      plan_(tree_, scalars),
      lanes_(lanes),
      variables_(variables) {}

void Group::resize(std::size_t slots) {
  q_.resize(slots * at(tree_.nq())), y_.resize(slots * at(tree_.nv())), effort_.resize(slots * at(tree_.nv()));
  turns_.resize(slots * tree_.loops().size());
  time_.resize(slots), h_.resize(slots), diverged_.resize(slots);
}

int Group::add(int world) {
  const int slot = worlds();
  world_.push_back(world);
  if (slot % lanes_ == 0) resize(at(slot + lanes_));
  return slot;
}

void Group::copy_slot(int from, int to) {
  for (int i = 0; i < tree_.nq(); ++i) q_[place(to, tree_.nq(), i)] = q_[place(from, tree_.nq(), i)];
  for (int i = 0; i < tree_.nv(); ++i) {
    y_[place(to, tree_.nv(), i)] = y_[place(from, tree_.nv(), i)];
    effort_[place(to, tree_.nv(), i)] = effort_[place(from, tree_.nv(), i)];
  }
  std::copy_n(turns_.data() + turn(from), tree_.loops().size(), turns_.data() + turn(to));
  time_[at(to)] = time_[at(from)], h_[at(to)] = h_[at(from)], diverged_[at(to)] = diverged_[at(from)];
}

int Group::remove(int slot) {
  const int last = worlds() - 1, moved = slot == last ? -1 : world_[at(last)];
  if (moved >= 0) copy_slot(last, slot), world_[at(slot)] = moved;
  world_.pop_back();
  if (last % lanes_ == 0) resize(at(last));  // its block is empty
  return moved;
}

void Group::set_values(int slot, double time, const double* q, const double* y, std::span<const Turns> turns) noexcept {
  for (int i = 0; i < tree_.nq(); ++i) q_[place(slot, tree_.nq(), i)] = q[i];
  for (int i = 0; i < tree_.nv(); ++i) y_[place(slot, tree_.nv(), i)] = y[i];
  for (std::size_t i = 0; i < tree_.loops().size(); ++i) turns_[turn(slot) + i] = i < turns.size() ? turns[i] : Turns{};
  time_[at(slot)] = time;
}

void Group::get_values(int slot, double* q, double* y) const noexcept {
  for (int i = 0; q != nullptr && i < tree_.nq(); ++i) q[i] = q_[place(slot, tree_.nq(), i)];
  for (int i = 0; y != nullptr && i < tree_.nv(); ++i) y[i] = y_[place(slot, tree_.nv(), i)];
}

void Group::set_state(int slot, const State& state) {
  MT_REQUIRE(state.variables() == variables_, "a state in the variables of the group");
  set_values(slot, state.time(), state.q().data(), state.y().data(), state.turns());
}

void Group::get_state(int slot, State& state) const {
  MT_REQUIRE(state.variables() == variables_, "a state in the variables of the group");
  std::vector<double> q(at(tree_.nq())), y(at(tree_.nv()));
  get_values(slot, q.data(), y.data());
  state.assign(time_[at(slot)], q, y, tree_);
  state.set_turns(turns(slot));
}

void Group::set_efforts(int slot, std::span<const ExtraEffort> efforts) {
  for (int i = 0; i < tree_.nv(); ++i) effort_[place(slot, tree_.nv(), i)] = 0;
  for (const ExtraEffort& e : efforts) {
    const int b = tree_.carrier(e.joint);
    if (b < 0 || (tree_.joint(b).locked >> e.dof & 1u) != 0) continue;
    effort_[place(slot, tree_.nv(), tree_.first_p(b) + e.dof)] = e.value;
    efforts_ = true;
  }
}

// Lanes after the last world are copies of it, with a step of 0.
Block Group::block(int number) {
  const int first = number * lanes_;
  for (int slot = std::max(worlds(), first); slot < first + lanes_; ++slot) copy_slot(worlds() - 1, slot), h_[at(slot)] = 0;
  const std::size_t q = place(first, tree_.nq(), 0), y = place(first, tree_.nv(), 0);
  return {q_.data() + q,
          y_.data() + y,
          efforts_ ? effort_.data() + y : nullptr,
          time_.data() + at(first),
          h_.data() + at(first),
          diverged_.data() + at(first),
          turns_.data() + turn(first)};
}

}  // namespace momentree::batch
