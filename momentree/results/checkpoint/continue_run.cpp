// A checkpoint is applied to a simulation only if it fits: numbers that are out of range would otherwise stop the program.
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/results/checkpoint/checkpoint.hpp>

namespace momentree::io {

namespace {

class Fit {
 public:
  Fit(const Simulation& simulation, const RunState& run, const std::string& path, const CheckpointWords& words)
      : now_(simulation.run_state()),
        world_(simulation.world()),
        run_(run),
        topology_(run.world.engine.topology),
        path_(path),
        words_(words),
        model_(model_with(run.world)),
        bodies_(model_.size()) {}

  void check() {
    const Topology& own = now_.world.engine.topology;
    require(topology_.model == own.model && topology_.places.size() == at(bodies_), "another model");
    require(run_.queue.entries.size() == now_.queue.entries.size(), "a run with other events");
    check_places();
    check_joints();
    check_loops();
    check_state();
    check_springs();
    for (const QueueState::Borne& b : run_.queue.strengths)
      require(b.strength.spring < 0 ? joint(b.strength.joint) || loops_.contains(b.strength.joint) : spring(b.strength.spring),
              whole);
    for (const auto& [number, name] : run_.world.joint_names) require(body(number) || loop_number(number - first_loop), whole);
    for (const auto& [number, name] : run_.world.mechanism_names) require(body(number), whole);
  }

 private:
  static constexpr const char* whole = "";
  void require(bool holds, const char* what) const {
    if (holds) return;
    const std::string problem = std::string(words_.name) + (what == whole ? " is damaged" : std::string(" is of ") + what);
    throw_error({problem, path_, words_.again});
  }
  Model model_with(const WorldSnapshot& snapshot) const {
    Model model = first_model(world_);
    try {
      for (const BodySpec& each : snapshot.added) model.add_unjudged(each);
      for (const Collider& each : snapshot.added_colliders) model.add_collider(each);
    } catch (const Error&) {
      require(false, whole);
    }
    return model;
  }
  bool body(int number) const { return number >= 0 && number < bodies_; }
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  bool spring(int number) const { return number >= 0 && number < world_.springs(); }
  bool joint(int number) const { return body(number) && carried_[at(number)] != 0; }

  void check_places() {
    carried_.assign(at(bodies_), 0);
    kinds_.assign(at(bodies_), Kind::weld);
    for (const Topology::Place& place : topology_.places) {
      if (place.joint < 0) continue;
      require(body(place.joint) && carried_[at(place.joint)] == 0, whole);
      carried_[at(place.joint)] = 1;
      require(place.parent == -1 || (body(place.parent) && topology_.places[at(place.parent)].joint >= 0), whole);
      require(!place.reversed || place.parent >= 0, whole);
    }
    // No body is outboard of itself: every path inboard ends at the ground.
    std::vector<char> known(at(bodies_), 0);
    std::vector<int> path;
    for (int b = 0; b < bodies_; ++b) {
      path.clear();
      int inner = b;
      for (; inner >= 0 && known[at(inner)] == 0; inner = topology_.places[at(inner)].parent) {
        known[at(inner)] = 1;
        path.push_back(inner);
      }
      require(inner < 0 || known[at(inner)] == 2, whole);
      for (const int each : path) known[at(each)] = 2;
    }
  }

  void check_joints() {
    for (int j = 0; j < bodies_; ++j) kinds_[at(j)] = model_[JointId{j}].joint.kind;
    const int shared = world_.tree().shared_parameters(), own = static_cast<int>(topology_.own.size());
    const auto& given = topology_.functions.empty() ? now_.world.engine.topology.functions : topology_.functions;
    const int functions = static_cast<int>(given.size());
    for (const Topology::Changed& c : topology_.changed) {
      require(body(c.joint), whole);
      require(c.as.parameters >= -1 && c.as.parameters < shared + own, whole);
      require(c.as.function >= -1 && c.as.function < functions, "a run with other functions");
      require(c.as.locked >> info(c.as.kind).nv == 0, whole);
      kinds_[at(c.joint)] = c.as.kind;
    }
    for (int j = world_.start().bodies; j < bodies_; ++j) {  // the model has none of these
      const auto changed = [j](const Topology::Changed& c) { return c.joint == j; };
      require(!joint(j) || std::any_of(topology_.changed.begin(), topology_.changed.end(), changed), whole);
    }
    for (const Topology::Own& o : topology_.own) require(body(o.joint), whole);
  }

  void check_springs() const {
    for (const Topology::SpringChange& change : topology_.springs) {
      require(spring(change.spring), whole);
      require(check_spring(with_law(world_.model().springs()[at(change.spring)], change.law)).empty(), whole);
    }
  }

  static bool loop_number(int number) { return number >= 0 && number < 1 << 20; }  // far more than a run can make

  int loop_dofs(int joint) const {
    for (const Loop& loop : topology_.loops)
      if (loop.id().index == joint) return info(loop.joint.kind).nv;
    return 0;
  }

  void check_loops() {
    const auto alive = [this](int b) { return body(b) && topology_.places[at(b)].joint >= 0; };
    for (const Loop& loop : topology_.loops) {
      require(loop_number(loop.number) && loops_.insert(loop.id().index).second, whole);
      require(alive(loop.body) && (loop.to == -1 || alive(loop.to)) && loop.body != loop.to, whole);
      const KindInfo& kind = info(loop.joint.kind);
      require(loop.joint.locked >> kind.nv == 0, whole);
      require(loop.joint.locked == 0 || loop.held.size() == kind.nq, whole);
    }
    require(run_.world.engine.turns.size() <= topology_.loops.size(), whole);
  }

  void check_state() const {
    const Snapshot& engine = run_.world.engine;
    std::size_t nq = 0, nv = 0;
    for (int j = 0; j < bodies_; ++j) {
      if (!joint(j)) continue;
      const KindInfo& kind = info(kinds_[at(j)]);
      nq += at(kind.nq), nv += at(kind.nv);
    }
    require(engine.q.size() == nq && engine.y.size() == nv && std::isfinite(engine.time), whole);
    for (const auto* numbers : {&engine.q, &engine.y})
      require(std::all_of(numbers->begin(), numbers->end(), [](double x) { return std::isfinite(x); }), whole);
    for (const Turns& turns : engine.turns) require(std::isfinite(turns.first) && std::isfinite(turns.second), whole);
    // A run whose events close a loop goes on in velocities.
    require(engine.variables == now_.world.engine.variables || engine.variables == Variables::velocities,
            "a run in other variables");
    require(std::isfinite(run_.proposal) && run_.proposal > 0, whole);
    for (const ActiveLimit& limit : run_.world.active_limits)
      require(loops_.contains(limit.joint) ? limit.dof >= 0 && limit.dof < loop_dofs(limit.joint)
                                           : joint(limit.joint) && limit.dof >= 0 && limit.dof < info(kinds_[at(limit.joint)]).nv,
              whole);
  }

  const RunState now_;
  const World& world_;
  const RunState& run_;
  const Topology& topology_;
  const std::string& path_;
  const CheckpointWords& words_;
  const Model model_;  ///< with the bodies that were added
  const int bodies_;
  std::vector<char> carried_;  // by joint
  std::vector<Kind> kinds_;    // by joint
  std::set<int> loops_;        // numbers of loop joints, as handles
};

}  // namespace

void require_fit(const Simulation& simulation, const Checkpoint& checkpoint, const std::string& path,
                 const CheckpointWords& words) {
  Fit(simulation, checkpoint.run, path, words).check();
}

void continue_run(Simulation& simulation, const Checkpoint& checkpoint) {
  const Topology own = simulation.world().tree().topology();
  RunState run = checkpoint.run;
  Topology& topology = run.world.engine.topology;
  if (topology.functions.empty()) topology.functions = own.functions;
  topology.loads = own.loads;
  simulation.continue_from(run);
}

}  // namespace momentree::io
