#include <momentree/model/model.hpp>

#include <algorithm>
#include <utility>

#include <momentree/base/wildcard.hpp>
#include <momentree/math/unit.hpp>
#include <momentree/model/ids.hpp>
#include <momentree/model/start.hpp>

namespace momentree {

namespace {

// Only for quaternions that check_body() found to be nearly of unit length.
void normalise_quaternion(Values& q, const char* units) {
  for (int i = 0; i < q.size(); ++i)
    if (units[i] == 'n') {
      const Quat u = unit(Quat{q[i], q[i + 1], q[i + 2], q[i + 3]});
      q[i] = u.w, q[i + 1] = u.x, q[i + 2] = u.y, q[i + 3] = u.z;
      return;
    }
}

void complete(BodySpec& spec) {
  const KindInfo& kind = info(spec.joint.kind);
  if (spec.joint_name.empty()) spec.joint_name = spec.name;
  if (kind.axis) spec.joint.axis = unit(spec.joint.axis);
  if (kind.axis2) spec.joint.axis2 = unit(spec.joint.axis2);
  spec.at.rotation = unit(spec.at.rotation);
  spec.child_at.rotation = unit(spec.child_at.rotation);
  normalise_quaternion(spec.q, kind.q_units);
  normalise_quaternion(spec.joint.parameters.rest, kind.q_units);
}

std::string prefix(const std::string& name) { return name.substr(0, name.find('/')); }

std::vector<std::string> names(const auto& by_name) {
  std::vector<std::string> all;
  all.reserve(by_name.size());
  for (const auto& [name, index] : by_name) all.push_back(name);
  std::sort(all.begin(), all.end());  // so that the suggestion does not depend on the order of a hash table
  return all;
}

BodyId look_up(const auto& by_name, std::string_view name, const char* what) {
  const auto found = by_name.find(name);
  if (found == by_name.end())
    throw_error({"there is no " + std::string(what) + " '" + std::string(name) + "'", "", did_you_mean(name, names(by_name))});
  return {found->second};
}

}  // namespace

BodyId Model::add(BodySpec spec) {
  const MassProblem problem = check_mass(spec.mass, spec.inertia);
  if (!problem.what.empty() && !problem.warning) throw_error({problem.what, spec.name, problem.hint});
  return add_unjudged(std::move(spec));
}

BodyId Model::add_unjudged(BodySpec spec) {
  for (const BodyProblem& problem : check_body(spec)) throw_error({problem.field + ": " + problem.what, spec.name, problem.hint});
  if (spec.parent.index < -1 || spec.parent.index >= size())
    throw_error(
        {"the parent is not a body of this model", spec.name, "add the parent first, and give what add() returned for it"});
  complete(spec);
  if (info(spec.joint.kind).nq == 1) begin_motion(spec.joint.parameters.drive, start_coordinates(spec)[0], 0);
  if (by_body_->contains(spec.name))
    throw_error({"there is already a body with that name", spec.name, "body names must be unique in a model"});
  if (by_joint_->contains(spec.joint_name) || has_spring(spec.joint_name))
    throw_error(
        {"there is already a " + std::string(has_spring(spec.joint_name) ? "spring" : "joint") + " '" + spec.joint_name + "'",
         spec.name, "joint names must be unique in a model"});

  detail::forget(compiled_);
  const int index = size();
  by_body_.own().emplace(spec.name, index);
  by_joint_.own().emplace(spec.joint_name, index);
  if (spec.parent == ground) by_mechanism_.own().emplace(prefix(spec.name), index);
  for (ContactRule& rule : contact_rules_) {
    if (!rule.one_name.empty() && names_body(rule.one_name, spec.name)) rule.one.push_back({index});
    if (!rule.other_name.empty() && names_body(rule.other_name, spec.name)) rule.other.push_back({index});
  }
  bodies_.own().push_back(std::move(spec));
  return {index};
}

void Model::set_gravity(Vec3 gravity) {
  if (!std::isfinite(norm(gravity))) throw_error({"gravity must be finite numbers", "", "m/s², world axes"});
  detail::forget(compiled_);
  gravity_ = gravity;
}

void Model::add_force(BodyForce force) {
  if (force.body.index < 0 || force.body.index >= size())
    throw_error({"the force acts on no body of this model", "", "give what add() returned for the body"});
  for (const ForceProblem& problem : check_force(force))
    throw_error({problem.field + ": " + problem.what, "force on " + (*this)[force.body].name, problem.hint});
  detail::forget(compiled_);
  forces_.push_back(std::move(force));
}

JointId Model::add_loop(LoopSpec spec) {
  if (spec.name.empty()) throw_error({"a loop needs a name", "", "events and results refer to it by that name"});
  for (const BodyProblem& problem : check_loop(spec, size()))
    throw_error({problem.field + ": " + problem.what, "loop '" + spec.name + "'", problem.hint});
  if (by_joint_->contains(spec.name) || has_spring(spec.name))
    throw_error(
        {"there is already a joint or spring '" + spec.name + "'", "", "names of joints and springs are unique in a model"});
  const KindInfo& kind = info(spec.joint.kind);
  if (kind.axis) spec.joint.axis = unit(spec.joint.axis);
  if (kind.axis2) spec.joint.axis2 = unit(spec.joint.axis2);
  spec.at.rotation = unit(spec.at.rotation);
  spec.child_at.rotation = unit(spec.child_at.rotation);
  normalise_quaternion(spec.joint.parameters.rest, kind.q_units);
  begin_motion(spec.joint.parameters.drive, 0, 0);
  detail::forget(compiled_);
  const int number = first_loop + static_cast<int>(loops_.size());
  by_joint_.own().emplace(spec.name, number);
  loops_.push_back(std::move(spec));
  return {number};
}

CouplingId Model::add_coupling(const Coupling& coupling) {
  for (const CouplingProblem& problem : check_coupling(coupling, *this)) {
    const bool known = coupling.joint.index >= 0 && coupling.joint.index < size();
    throw_error({problem.field + ": " + problem.what,
                 known ? "coupling of '" + (*this)[coupling.joint].joint_name + "'" : "coupling", problem.hint});
  }
  detail::forget(compiled_);
  couplings_.push_back(coupling);
  return {static_cast<int>(couplings_.size()) - 1};
}

void Model::add_element(JointElement element) {
  for (const ElementProblem& problem : check_element(element, *this)) {
    const std::vector<JointId> joints = joints_of(element);
    const JointId first = joints.empty() ? JointId{} : joints.front();
    const bool known = first.index >= 0 && first.index < size();
    throw_error({problem.field + ": " + problem.what, known ? "element of '" + (*this)[first].joint_name + "'" : "element",
                 problem.hint});
  }
  detail::forget(compiled_);
  elements_.push_back(std::move(element));
}

SpringId Model::add_spring(Spring spring) {
  const auto wrong = [&](const std::string& what, std::string hint) {
    throw_error({what, (spring.inextensible ? "cable '" : "spring '") + spring.name + "'", std::move(hint)});
  };
  if (spring.name.empty() || spring.name == "ground")
    wrong("a spring needs a name of its own", "events and results refer to it by its name");
  if (has_spring(spring.name)) wrong("there is already a spring with that name", "spring names must be unique in a model");
  if (has_joint(spring.name)) wrong("there is already a joint with that name", "springs and joints need different names");
  for (const SpringEnd* end : {&spring.from, &spring.to})
    if (end->body.index < ground.index || end->body.index >= size())
      wrong("an end is on no body of this model", "give what add() returned for the body, or ground");
  for (SpringProblem& problem : check_spring(spring)) wrong(problem.field + ": " + problem.what, std::move(problem.hint));
  if (!spring.rest) spring.rest = norm(start_place(bodies(), spring.to) - start_place(bodies(), spring.from));
  if (spring.inextensible && !(*spring.rest > 0)) wrong("its ends coincide at the start", "give it a length");
  detail::forget(compiled_);
  has_cables_ = has_cables_ || spring.inextensible;
  springs_.push_back(std::move(spring));
  return {static_cast<int>(springs_.size()) - 1};
}

bool Model::has_spring(std::string_view name) const {
  return std::any_of(springs_.begin(), springs_.end(), [&](const Spring& spring) { return spring.name == name; });
}

SpringId Model::spring(std::string_view name) const {
  for (std::size_t s = 0; s < springs_.size(); ++s)
    if (springs_[s].name == name) return {static_cast<int>(s)};
  std::vector<std::string> known;
  for (const Spring& spring : springs_) known.push_back(spring.name);
  throw_error({"there is no spring '" + std::string(name) + "'", "", did_you_mean(name, known)});
}

void Model::reserve(int count) {
  if (count < 0 || static_cast<std::size_t>(count) <= bodies_->capacity()) return;
  const std::size_t room = std::max(static_cast<std::size_t>(count), bodies_->capacity() + bodies_->capacity() / 2);
  bodies_.own().reserve(room);
  by_body_.own().reserve(room);
  by_joint_.own().reserve(room);
}

void Model::keep(int count) {
  MT_REQUIRE(count >= 0, "a number of bodies");
  detail::forget(compiled_);
  std::erase_if(forces_, [count](const BodyForce& force) { return force.body.index >= count; });
  while (!loops_.empty() && (loops_.back().body.index >= count || loops_.back().to.index >= count)) {
    by_joint_.own().erase(loops_.back().name);
    loops_.pop_back();
  }
  std::erase_if(couplings_, [count](const Coupling& c) { return std::max(c.joint.index, c.follows.index) >= count; });
  std::erase_if(elements_, [count](const JointElement& element) {
    const std::vector<JointId> joints = joints_of(element);
    return std::any_of(joints.begin(), joints.end(), [count](JointId joint) { return joint.index >= count; });
  });
  std::erase_if(colliders_, [count](const Collider& c) { return c.body.index >= count; });
  for (ContactRule& rule : contact_rules_)
    for (std::vector<BodyId>* const set : {&rule.one, &rule.other}) {
      const bool all = set->empty();
      std::erase_if(*set, [count](BodyId b) { return b.index >= count; });
      if (!all && set->empty()) set->push_back({-2});  // no body, which is not the same as all
    }
  std::erase_if(springs_, [count](const Spring& s) { return std::max(s.from.body.index, s.to.body.index) >= count; });
  has_cables_ = std::any_of(springs_.begin(), springs_.end(), [](const Spring& s) { return s.inextensible; });
  while (size() > count) {
    const BodySpec& last = bodies_.own().back();
    by_body_.own().erase(last.name);
    by_joint_.own().erase(last.joint_name);
    Numbers& roots = by_mechanism_.own();
    const auto mechanism = roots.find(prefix(last.name));
    if (mechanism != roots.end() && mechanism->second == size() - 1) roots.erase(mechanism);
    bodies_.own().pop_back();
  }
}

BodyId Model::body(std::string_view name) const { return look_up(*by_body_, name, "body"); }
JointId Model::joint(std::string_view name) const { return inboard_joint(look_up(*by_joint_, name, "joint")); }

std::string Model::mechanism_name(BodyId root) const {
  const std::string& name = (*this)[root].name;
  std::string mechanism = prefix(name);
  const auto first = by_mechanism_->find(mechanism);
  return first == by_mechanism_->end() || first->second == root.index ? mechanism : name;
}

}  // namespace momentree
