#include <momentree/batch/simulated_world.hpp>

#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/batch/batch.hpp>
#include <momentree/integrate/integrator.hpp>

namespace momentree::batch {

namespace {

constexpr int most_dofs = 6;

std::size_t first_effort(int joint) { return static_cast<std::size_t>(most_dofs * joint); }

bool follows_motion(const Tree& tree, int body) {
  const JointParameters* const parameters = tree.parameters(body);
  return parameters != nullptr && parameters->drive != nullptr && parameters->drive->moves();
}

}  // namespace

Integration integration_of(const Model& model, const BatchOptions& options) {
  if (!supports_contact(method_named(options.contact_method))) {
    std::string known;
    for (const std::string& name : integration_methods())
      if (supports_contact(name)) known += (known.empty() ? "\"" : ", \"") + name + '"';
    throw_error({"batches can't step contact by the method '" + options.contact_method + "'", "", "use one of " + known});
  }
  Integration how{.method = model.has_contact() ? method_named(options.contact_method) : "rk4", .variables = options.variables};
  how.step = options.step;
  return how;
}

Topology bare_topology(const World& world) {
  Topology bare = world.tree().topology();
  bare.contacts.clear(), bare.functions.clear();
  for (Topology::Changed& changed : bare.changed) changed.as.function = -1;
  for (Loop& loop : bare.loops) loop.joint.function = -1;
  for (const ActiveLimit& rests : world.constraints().active_limits) {
    const unsigned others = ~(1u << rests.dof);
    for (Topology::Changed& changed : bare.changed)
      if (changed.joint == rests.joint) changed.as.locked &= others;
    for (Loop& loop : bare.loops) {
      if (loop.id().index != rests.joint) continue;
      loop.joint.locked &= others;
      if (loop.joint.locked == 0) loop.held = {};
    }
  }
  return bare;
}

SimulatedWorld::SimulatedWorld(const Model& model, const Integration& integration)
    : simulation_(model, integration),
      compared_(simulation_.world().tree().revision()),
      by_joint_(first_effort(simulation_.world().tree().bodies())) {}

void SimulatedWorld::restart(const WorldSnapshot& start, const Model& model) {
  if (made_loops) simulation_ = Simulation(model, simulation_.integration());
  made_loops = false;
  momentree::restart(simulation_, start);
  first_event_ = 0;
  compared_ = simulation_.world().tree().revision();
  changed_ = false;
}

void SimulatedWorld::set_efforts(std::span<const ExtraEffort> efforts) {
  efforts_.assign(efforts.begin(), efforts.end());
  std::fill(by_joint_.begin(), by_joint_.end(), 0.0);
  for (const ExtraEffort& e : efforts_) by_joint_[first_effort(e.joint) + static_cast<std::size_t>(e.dof)] = e.value;
  efforts_changed_ = true;
}

JointFunction SimulatedWorld::function_of(int joint) const {
  const double* const values = by_joint_.data() + first_effort(joint);
  return [values](const EvaluationContext&, std::span<double> efforts) { std::copy_n(values, efforts.size(), efforts.begin()); };
}

// Functions stay with their joints until these break or become others.
void SimulatedWorld::prepare(Use use) {
  const World& world = simulation_.world();
  const Tree& tree = world.tree();
  std::vector<JointDriver> missing;
  std::vector<int> joints;
  for (const ExtraEffort& e : efforts_) {
    const int body = tree.carrier(e.joint);
    if (body < 0 || tree.function(body) != nullptr || follows_motion(tree, body)) continue;
    if (std::find(joints.begin(), joints.end(), e.joint) != joints.end()) continue;
    joints.push_back(e.joint);
    missing.push_back({std::string(world.joint_name({e.joint})), function_of(e.joint)});
  }
  const bool renew = std::exchange(efforts_changed_, false) && has_functions(tree);
  if (!missing.empty())
    simulation_.drive_all(std::move(missing));
  else if (renew)
    functions_changed(simulation_, use == Use::read);
}

std::string SimulatedWorld::step(double h) {
  simulation_.forget_events(simulation_.time());
  first_event_ = simulation_.events().size();
  const RunResult run = simulation_.run_until(simulation_.time() + h);
  if (run) return {};
  return run.reason.empty() ? "the step was interrupted" : run.reason;
}

bool SimulatedWorld::left(const Topology& group, const Tree& declared) {
  const std::uint64_t revision = simulation_.world().tree().revision();
  if (revision == compared_) return false;
  compared_ = revision;
  topology_ = bare_topology(simulation_.world());
  simplify(topology_, declared);
  return !same(topology_, group);
}

}  // namespace momentree::batch
