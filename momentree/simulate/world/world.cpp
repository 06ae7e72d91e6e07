#include <momentree/simulate/world/world.hpp>

#include <algorithm>

#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/model/start.hpp>
#include <momentree/simulate/assembly.hpp>
#include <momentree/simulate/world/world_elements.hpp>
#include <momentree/tree/edit.hpp>
#include <momentree/tree/lasting_function.hpp>

namespace momentree {

World::World(const Model& model, Variables variables, Variables with_loops)
    : model_(model),
      variables_(has_equations(model) ? with_loops : variables),
      loop_variables_(with_loops),
      start_{model.size(), model.gravity()} {
  const std::vector<SingularJoint> singular = singular_joints(model_);
  if (!singular.empty()) {
    const BodySpec& body = model_[singular.front().body];
    throw_error({singular.front().what, "joint '" + body.joint_name + "'", singular.front().hint});
  }
  restore(0, {}, {});
}

namespace {

struct KeptFunction {
  std::string joint;  ///< its name
  Kind kind;
  std::shared_ptr<const JointFunction> function;
};

}  // namespace

// The free joint of a part that broke off is named after its body, and often the joint that broke has the same name. A free root
// that was freed at its own frame is unchanged: neither a state document nor the motion can tell the difference.
bool is_broken(const World& world, std::string_view name, JointId found) {
  const Model& model = world.model();
  const Tree& tree = world.tree();
  if (is_loop(found) || !model.has_joint(name)) return false;
  const int b = tree.carrier(found.index);
  if (b < 0) return false;
  const Joint& now = tree.joint(b);
  const auto moved = [](const Pose& pose) {
    const Quat& r = pose.rotation;
    return !(pose.position == Vec3{}) || r.w != 1 || r.x != 0 || r.y != 0 || r.z != 0;
  };
  if (now.kind != Kind::free || tree.parent(b) >= 0 || moved(now.at) || moved(now.child_at)) return false;
  const JointId declared = model.joint(name);
  return model.joint_spec(declared).kind != Kind::free || model[BodyId{declared.index}].parent != ground;
}

void World::restore(double time, const Forest& forest, std::span<const JointStart> joints) {
  MT_REQUIRE(std::isfinite(time), "a finite time");
  std::vector<KeptFunction> functions;  // those that a user gave to the model's joints stay
  const auto keep = [&functions](const std::string& joint, Kind kind, const JointFunction* function) {
    if (function == nullptr) return;
    const LastingFunction* const lasting = is_lasting(function) ? function->target<LastingFunction>() : nullptr;
    const JointFunction& given = lasting != nullptr ? lasting->replaceable : *function;  // elements are attached anew
    if (given) functions.push_back({joint, kind, std::make_shared<const JointFunction>(given)});
  };
  for (const int b : tree_.joints_with().forces) keep(names_.joint(tree_.joint_of(b)), tree_.joint(b).kind, tree_.function(b));
  for (const Loop& loop : tree_.loops()) keep(names_.joint(loop.id().index), loop.joint.kind, tree_.function(loop.joint));
  const std::vector<Topology::Loaded> loads(tree_.loads().functions.begin(), tree_.loads().functions.end());
  if (forest.places.size() < model_.bodies().size()) model_.keep(start_.bodies);
  tree_ = model_.compiled();
  constraints_.former_contacts.clear(), constraints_.overlapping = forest.overlapping;
  start_.bodies = model_.size();
  declared_ = names_ = Names(model_);
  constraints_.active_limits = forest.active_limits;
  put_together(forest);
  put_springs(forest.springs);
  for (const int c : forest.ended_couplings)
    if (tree_.coupling_acts(c)) tree_.edit().end_coupling(c);
  for (const ActiveLimit& h : constraints_.active_limits)
    MT_REQUIRE(is_loop({h.joint}) || (h.dof >= 0 && h.dof < info(tree_.joint(carrier({h.joint})).kind).nv),
               "a degree of freedom of the joint");
  for (KeptFunction& each : functions) {
    // By name: a loop joint that takes the place of a broken joint has the number of that one.
    const int joint = names_.find_joint(each.joint);
    if (joint < 0 || !model_.has_joint(each.joint) || model_.joint_spec(model_.joint(each.joint)).kind != each.kind) continue;
    if (is_broken(*this, each.joint, {joint})) continue;
    const Loop* const loop = tree_.loops().find({joint});
    if (loop != nullptr && loop->joint.kind == each.kind)
      tree_.edit().set_loop_function(joint - first_loop, std::move(each.function));
    else if (const int b = is_loop({joint}) ? -1 : tree_.carrier(joint); b >= 0 && tree_.joint(b).kind == each.kind)
      tree_.edit().set_function(b, std::move(each.function));
  }
  for (const Topology::Loaded& load : loads)
    if (load.body < model_.size() && tree_.alive(load.body)) tree_.edit().set_body_function(load.body, load.function);
  State state(tree_, own_variables());
  workspace_ = Workspace<double>(tree_);
  motions_.resize(static_cast<std::size_t>(model_.size()));
  motions_of_ = accelerations_of_ = {};

  put_values(time, forest, joints, state);
  if (!forest.loops.empty()) {
    std::vector<Turns> turns;
    for (const Loop& loop : tree_.loops())
      for (const Forest::LoopJoint& each : forest.loops)
        if (each.name == names_.joint(loop.id().index)) turns.push_back(each.turns);
    state.set_turns(turns);
  }
  if (tree_.has_loops()) {
    GivenStart given = given_start(model_, tree_);
    given.by_run = !forest.places.empty();
    for (const JointStart& j : joints) {
      const int first = tree_.first_p(tree_.carrier(j.joint.index)),
                count = info(tree_.joint(tree_.carrier(j.joint.index)).kind).nv;
      if (!j.q.empty()) std::fill_n(given.q.begin() + first, count, 1);
      if (!j.v.empty() || !j.p.empty()) std::fill_n(given.v.begin() + first, count, 1);
    }
    std::optional<Error> error = assemble(tree_, model_, names_, state, given);
    if (!error) error = conflicting_motions(tree_, names_, state);
    // In a document a loop may be beyond stops that it was given there.
    if (!error && forest.loops.empty()) error = beyond_stops(tree_, names_, state);
    if (error) throw_error(std::move(*error));
  }
  state_ = std::move(state);
  attach_elements();
}

// Start values: those of the model if the document gives none.
void World::put_values(double time, const Forest& forest, std::span<const JointStart> joints, State& state) const {
  std::vector<double> v(static_cast<std::size_t>(tree_.nv()));
  const State::Edit edit = state.edit();
  edit.time = time;
  const auto put = [](const Values& from, int at, std::span<double> to) {
    for (int i = 0; i < from.size(); ++i) to[static_cast<std::size_t>(at + i)] = from[i];
  };
  const auto first_q = [this](int joint) { return tree_.first_q(tree_.carrier(joint)); };
  const auto first_p = [this](int joint) { return tree_.first_p(tree_.carrier(joint)); };
  std::vector<char> changed(static_cast<std::size_t>(model_.size()), 0);
  for (const Forest::Changed& c : forest.changed) {
    changed[static_cast<std::size_t>(c.joint)] = 1;
    put(joint_zero(c.as.kind), first_q(c.joint), edit.q);
  }
  for (int j = 0; j < model_.size(); ++j) {
    if (changed[static_cast<std::size_t>(j)] != 0 || tree_.carrier(j) < 0) continue;
    put(start_coordinates(model_[{j}]), first_q(j), edit.q);
    put(model_[{j}].v, first_p(j), v);
  }
  for (const JointStart& j : joints) {
    const KindInfo& kind = info(tree_.joint(carrier(j.joint)).kind);
    const auto fits = [](const Values& values, int count) { return values.empty() || values.size() == count; };
    MT_REQUIRE(fits(j.q, kind.nq) && fits(j.v, kind.nv) && fits(j.p, kind.nv),
               "as many numbers as the joint has coordinates or velocities, or none");
    put(j.q, first_q(j.joint.index), edit.q);
    put(j.v, first_p(j.joint.index), v);
  }
  follow_motions(tree_, time, edit.q.data(), v.data());
  const bool by_velocities =
      state.variables() == Variables::velocities &&
      std::all_of(joints.begin(), joints.end(), [](const JointStart& j) { return j.p.empty() || !j.v.empty(); });
  std::vector<double> y(v.size());
  if (by_velocities) {
    y = v;
  } else {
    project_momentum(tree_, state.q().data(), v.data(), y.data());
    for (const JointStart& j : joints) put(j.p, first_p(j.joint.index), y);
  }
  for (const int b : tree_.order())  // a locked DoF has no momentum or velocity of its own
    for (int i = 0; i < info(tree_.joint(b).kind).nv; ++i)
      if ((tree_.joint(b).locked >> i & 1u) != 0) y[static_cast<std::size_t>(tree_.first_p(b) + i)] = 0;
  follow_motions(tree_, time, edit.q.data(), y.data());
  if (state.variables() == Variables::velocities && !by_velocities) {
    State momenta(tree_);
    momenta.assign(time, edit.q, y, tree_);
    Workspace<double> workspace(tree_);
    forward_dynamics(tree_, momenta, workspace);
    std::copy_n(workspace.v.get(), y.size(), y.begin());
  }
  std::copy(y.begin(), y.end(), edit.y.begin());
}

// Topology and names of a newly compiled tree.
void World::put_together(const Forest& forest) {
  if (forest.places.empty()) return;
  Topology topology = tree_.topology();
  topology.places = forest.places;
  for (const Forest::Changed& c : forest.changed) {
    Joint joint = c.as;
    const Joint& own = tree_.joint(c.joint);  // nothing has been re-rooted yet: the model's joint with that number
    const JointParameters* declared = tree_.parameters(c.joint);
    joint.parameters = -1;
    if (declared != nullptr && c.parameters == *declared) {
      joint.parameters = own.parameters;
    } else if (!(c.parameters == JointParameters{})) {
      joint.parameters = tree_.shared_parameters() + static_cast<int>(topology.own.size());
      topology.own.push_back({c.joint, c.parameters});
    }
    topology.changed.push_back({c.joint, joint});
    names_.name_joint(c.joint, c.name);
  }
  topology.loops.clear();
  for (const LoopSpec& loop : model_.loops()) names_.remove_joint(model_.joint(loop.name).index);
  for (const Forest::LoopJoint& each : forest.loops) {
    Loop loop = each.loop;  // a loop of the model keeps its number
    const bool declared = model_.has_joint(each.name) && is_loop(model_.joint(each.name));
    loop.number = (declared ? model_.joint(each.name).index : names_.loops_end()) - first_loop;
    names_.add_loop(loop.id().index, each.name);
    for (ActiveLimit limit : each.active_limits) {
      limit.joint = loop.id().index;
      constraints_.active_limits.push_back(limit);
    }
    topology.loops.push_back(std::move(loop));
  }
  std::sort(topology.loops.begin(), topology.loops.end(), [](const Loop& a, const Loop& b) { return a.number < b.number; });
  tree_.edit().restore(topology);
  for (int b = 0; b < model_.size(); ++b) names_.name_mechanism(b, {});
  for (const auto& [root, name] : forest.mechanisms) names_.name_mechanism(root, name);
}

void World::evaluate() const { forward_dynamics(tree_, state_, workspace_); }

const CheckedVector<BodyMotion>& World::motions() const {
  if (motions_of_ == state_.stamp()) return motions_;
  locate_bodies(tree_, state_, workspace_);
  for (const int b : tree_.order()) {
    const auto i = static_cast<std::size_t>(b);
    motions_[i] = user_motion(tree_, workspace_.bodies[i], b);
  }
  motions_of_ = state_.stamp();
  return motions_;
}

const std::vector<BodyAcceleration>& World::accelerations() const {
  if (accelerations_of_ == state_.stamp()) return accelerations_;
  locate_bodies(tree_, state_, workspace_);
  accelerate(tree_, state_, workspace_);
  accelerations_.assign(static_cast<std::size_t>(model_.size()), {});
  for (const int b : tree_.order())
    accelerations_[static_cast<std::size_t>(b)] = body_acceleration(tree_, state_, workspace_, {b});
  accelerations_of_ = state_.stamp();
  return accelerations_;
}

const State& World::state() const {
  MT_REQUIRE(!workspace_.in_function, inside_function);
  return state_;
}

int World::carrier(JointId number) const {
  MT_REQUIRE(number.index >= 0 && number.index < tree_.bodies() && tree_.carrier(number.index) >= 0,
             "the joint is in this world");
  return tree_.carrier(number.index);
}

namespace {
// From the origin of the child's frame to that of the joint's frame on it.
Wrench at_joint(const Pose& child_at, const Wrench& on_child) {
  return {on_child.force, on_child.torque - cross(child_at.position, on_child.force)};
}
}  // namespace

JointForces World::joint_forces(JointId number) const {
  const bool determined = loops_determine(number) && contacts_determine(number);
  if (is_loop(number)) {
    JointForces forces = loop_forces(number);
    forces.determined = determined;
    return forces;
  }
  const int b = carrier(number);
  accelerate(tree_, state_, workspace_);
  Values effort;
  double along[6];
  joint_effort(tree_, state_, workspace_, number, along);
  for (int i = 0; i < info(tree_.joint(b).kind).nv; ++i) effort.push_back(along[i]);
  return {{workspace_.a.get() + tree_.first_p(b), static_cast<std::size_t>(info(tree_.joint(b).kind).nv)},
          at_joint(tree_.joint(b).child_at, momentree::reaction(tree_, state_, workspace_, number)),
          at_joint(tree_.joint(b).child_at, bearing_reaction(tree_, state_, workspace_, number)),
          effort,
          determined};
}

bool World::loops_determine(JointId number, ReactionParts parts) const {
  if (!tree_.has_loops()) return true;
  accelerate(tree_, state_, workspace_);
  const ReactionParts open = is_loop(number) ? open_parts_of_link(tree_, workspace_, tree_.loops().place(number))
                                             : open_parts_of_joint(tree_, workspace_, carrier(number));
  return (open & parts) == 0;
}

Wrench World::reaction(JointId number) const {
  if (is_loop(number)) return loop_forces(number).reaction;
  const int b = carrier(number);
  accelerate(tree_, state_, workspace_);
  return at_joint(tree_.joint(b).child_at, momentree::reaction(tree_, state_, workspace_, number));
}

std::optional<std::pair<double, double>> World::single_dof(JointId number) const {
  if (is_loop(number)) {
    const JointView view = loop_view(number);
    return view.q.size() == 1 && view.v.size() == 1 ? std::optional(std::pair{view.q[0], view.v[0]}) : std::nullopt;
  }
  const int b = carrier(number);
  evaluate();
  const KindInfo& kind = info(tree_.joint(b).kind);
  if (kind.nq != 1 || kind.nv != 1) return std::nullopt;
  return std::pair{state_.q()[static_cast<std::size_t>(tree_.first_q(b))],
                   workspace_.v[static_cast<std::size_t>(tree_.first_p(b))]};
}

JointView World::joint(JointId number) const {
  if (is_loop(number)) return loop_view(number);
  const int b = carrier(number);
  evaluate();
  const Joint& j = tree_.joint(b);
  const KindInfo& kind = info(j.kind);
  const bool reversed = tree_.reversed(b);
  const BodyId inner{b}, outer{tree_.parent(b)};
  static constexpr double none[6] = {};
  const bool driven = tree_.link(b).driven != 0;
  const auto nq = static_cast<std::size_t>(kind.nq), nv = static_cast<std::size_t>(kind.nv);
  return {joint_name(number),
          j.kind,
          reversed ? outer : inner,
          reversed ? inner : outer,
          reversed,
          j.locked & ~constraints_.held(number.index),
          constraints_.held(number.index) | rests_in_steps(number.index),
          driven,
          j.at,
          j.child_at,
          j.axis,
          j.axis2,
          j.pitch,
          tree_.parameters(b),
          state_.q().subspan(static_cast<std::size_t>(tree_.first_q(b)), nq),
          {workspace_.v.get() + tree_.first_p(b), nv},
          driven ? std::span(none, nv) : p().subspan(static_cast<std::size_t>(tree_.first_p(b)), nv),
          driven ? std::span(none, nv) : pdot().subspan(static_cast<std::size_t>(tree_.first_p(b)), nv)};
}

Model first_model(const World& world) {
  Model model = world.model();
  model.keep(world.start().bodies);
  return model;
}

WorldSnapshot World::snapshot() const {
  WorldSnapshot all{take_snapshot(tree_, state_),
                    {},
                    {},
                    constraints_.active_limits,
                    {model_.bodies().begin() + start_.bodies, model_.bodies().end()}};
  for (const Collider& collider : model_.colliders())
    if (collider.body.index >= start_.bodies) all.added_colliders.push_back(collider);
  all.former_contacts = constraints_.former_contacts, all.overlapping = constraints_.overlapping;
  all.gravity = model_.gravity();
  for (int k = 0; k < model_.size(); ++k) {
    if (names_.joint(k) != declared_.joint(k)) all.joint_names.emplace_back(k, names_.joint(k));
    if (names_.mechanism(k) != declared_.mechanism(k)) all.mechanism_names.emplace_back(k, names_.mechanism(k));
  }
  for (int k = first_loop; k < names_.loops_end(); ++k)
    if (k >= declared_.loops_end() || names_.joint(k) != declared_.joint(k)) all.joint_names.emplace_back(k, names_.joint(k));
  return all;
}

void World::restore(const WorldSnapshot& snapshot) {
  momentree::restore(snapshot.engine, tree_, state_);
  if (!snapshot.added.empty() || model_.size() != start_.bodies) {
    model_.keep(start_.bodies);
    for (const BodySpec& body : snapshot.added) model_.add_unjudged(body);
    for (const Collider& collider : snapshot.added_colliders) model_.add_collider(collider);
    declared_ = Names(model_);
    make_room();
  }
  if (snapshot.gravity && !(*snapshot.gravity == model_.gravity())) set_gravity(*snapshot.gravity);
  names_ = declared_;
  constraints_.active_limits = snapshot.active_limits;
  constraints_.former_contacts = snapshot.former_contacts, constraints_.overlapping = snapshot.overlapping;
  for (const auto& [number, name] : snapshot.joint_names)
    number >= first_loop ? names_.add_loop(number, name) : names_.name_joint(number, name);
  for (const auto& [root, name] : snapshot.mechanism_names) names_.name_mechanism(root, name);
}

void World::drive(int joint, JointFunction function) {
  const bool loop = is_loop({joint});
  const JointFunction* const now = loop ? tree_.function(tree_.loops().find({joint})->joint) : tree_.function(carrier({joint}));
  // A joint with elements has their function until it breaks or becomes another. That one is none of theirs.
  if (!loop && !is_lasting(now) && function.target<LastingFunction>() == nullptr) end_elements(tree_, {joint});
  function = joined(now, std::move(function));
  auto shared = function ? std::make_shared<const JointFunction>(std::move(function)) : nullptr;
  if (loop)
    tree_.edit().set_loop_function(joint - first_loop, std::move(shared));
  else
    tree_.edit().set_function(carrier({joint}), std::move(shared));
  state_.replace(0, 0, {}, 0, 0, {}, tree_);
}

void World::load(int body, BodyFunction function) {
  tree_.edit().set_body_function(body, function ? std::make_shared<const BodyFunction>(std::move(function)) : nullptr);
  state_.replace(0, 0, {}, 0, 0, {}, tree_);
}

// Corrects the clock by a rounding error, or by more in a dry run; driven joints follow.
void World::set_time(double time) {
  const State::Edit edit = state_.edit();
  edit.time = time;
  follow_motions(tree_, time, edit.q.data(), edit.y.data());
}

void World::set_gravity(Vec3 gravity) {
  model_.set_gravity(gravity);  // may throw
  tree_.edit().set_gravity(gravity);
  state_.replace(0, 0, {}, 0, 0, {}, tree_);
}

int WorldConstraints::held(int joint, int dof) const {
  for (const ActiveLimit& h : active_limits)
    if (h.joint == joint && h.dof == dof) return h.sign;
  return 0;
}

unsigned World::rests_in_steps(int joint) const {
  unsigned bits = 0;
  if (workspace_.contacts != nullptr)
    for (const HeldStop& stop : workspace_.contacts->stops)
      if (stop.joint == joint && stop.rests) bits |= 1u << stop.dof;
  return bits;
}

unsigned WorldConstraints::held(int joint) const {
  unsigned bits = 0;
  for (const ActiveLimit& h : active_limits)
    if (h.joint == joint) bits |= 1u << h.dof;
  return bits;
}

// Active limits end when their joint, or its limits, are removed.
void World::forget_active_limits() {
  std::erase_if(constraints_.active_limits, [this](const ActiveLimit& h) {
    if (is_loop({h.joint})) {
      const Loop* const loop = tree_.loops().find({h.joint});
      return loop == nullptr || (loop->joint.locked >> h.dof & 1u) == 0 || !loop->parameters.limits.hard();
    }
    const int b = tree_.carrier(h.joint);
    const JointParameters* p = tree_.parameters(b);
    return (tree_.joint(b).locked >> h.dof & 1u) == 0 || p == nullptr || !p->limits.hard();
  });
}

Totals World::totals() const { return momentree::totals(tree_, state_, workspace_); }

std::vector<Mechanism> World::mechanisms() const {
  std::vector<Mechanism> all;
  for (int b : tree_.order()) {
    if (tree_.parent(b) < 0) all.push_back({mechanism_name({b}), {b}, tree_.joint(b).kind != Kind::free, {}});
    all.back().bodies.push_back({b});
  }
  return all;
}

MechanismNames World::mechanism_names() const {
  std::size_t known = 0;
  int root = tree_.first_root();
  while (root >= 0 && known < mechanism_names_.size() && mechanism_names_[known] == mechanism_name({root}))
    root = tree_.next_sibling(root), ++known;
  if (root < 0 && known == mechanism_names_.size()) return mechanism_names_;
  std::vector<std::string> names;
  for (int b = tree_.first_root(); b >= 0; b = tree_.next_sibling(b)) names.emplace_back(mechanism_name({b}));
  return mechanism_names_ = std::move(names);
}

}  // namespace momentree
