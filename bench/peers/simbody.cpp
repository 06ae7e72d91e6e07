// Simbody. A system's topology is fixed; joints that are made or broken at run time are constraints, declared in advance and
// enabled or disabled in the State. Unforeseen changes need another system, whose bodies are initialised with setQToFitTransform
// and setUToFitVelocity. Enabling a constraint does not change the state: solveForConstraintImpulses gives the impact, project()
// a cheaper correction; MobilizedBody::lock() sets the speed to zero.
#include <memory>
#include <string>

#include "evaluation.hpp"
#include "loops.hpp"
#include "measure.hpp"
#include "simbody_system.hpp"

namespace {

using namespace peers;

enum class How { rebuild, disable, lock, lock_impulse, weld_impulse, weld_project };

struct Engine : Trial {
  Engine(const Experiment& experiment, How way) : e(experiment), how(way) {
    now = std::make_unique<System>(e.links, how == How::disable ? e.body : -1);
    st::MobilizedBody& body = now->bodies[e.body];
    const Link& link = e.links[e.body];
    if (how == How::disable) {  // the revolute joint that will break is composed of constraints
      st::MobilizedBody& parent = now->bodies[link.parent];
      parts.push_back(st::Constraint::Ball(parent, vec(link.at), body, st::Vec3(0)));
      for (int k = 0; k < 2; ++k) {
        parts.push_back(st::Constraint::ConstantAngle(parent, st::UnitVec3(vec(link.turn.col(k))), body, st::UnitVec3(st::ZAxis),
                                                      st::Pi / 2));
      }
    }
    if (how == How::lock_impulse) {
      parts.push_back(st::Constraint::ConstantCoordinate(body, st::MobilizerQIndex(0), 0));
      parts.back().setDisabledByDefault(true);
    }
    now->start(e);
  }

  void change() override {
    st::State& state = now->state;
    if (how == How::disable) {
      for (const st::Constraint& part : parts) part.disable(state);
    }
    if (how == How::lock) now->bodies[e.body].lock(state);
    if (how == How::lock_impulse) {
      const double angle = now->bodies[e.body].getOneQ(state, 0);
      parts[0].enable(state);
      st::Constraint::ConstantCoordinate::downcast(parts[0]).setPosition(state, angle);
      now->impact();
    }
    if (how == How::rebuild) renew(e.body);
    if (how == How::weld_impulse || how == How::weld_project) {
      renew(-1);
      if (how == How::weld_impulse) now->impact();
      if (how == How::weld_project) now->system.project(now->state, 1e-10);
    }
    now->system.realize(now->state, st::Stage::Velocity);
  }
  void renew(int loose) {
    auto next = std::make_unique<System>(e.links, loose);
    if (e.change == Change::capture) {
      const st::Transform grip =
          ~now->bodies[e.to].getBodyTransform(now->state) * now->bodies[e.body].getBodyTransform(now->state);
      st::Constraint::Weld(next->bodies[e.to], grip, next->bodies[e.body], st::Transform());
    }
    next->copy(*now);
    now = std::move(next);
  }

  std::vector<Motion> motions() override {
    std::vector<Motion> all;
    for (const st::MobilizedBody& body : now->bodies) {
      const st::Transform& pose = body.getBodyTransform(now->state);
      const st::SpatialVec& velocity = body.getBodyVelocity(now->state);
      all.push_back({mat(pose.R()), vec(pose.p()), vec(velocity[1]), vec(velocity[0])});
    }
    return all;
  }

  Experiment e;
  How how;
  std::unique_ptr<System> now;
  std::vector<st::Constraint> parts;
};

std::vector<Way> ways(Change change) {
  if (change == Change::cut) {
    return {{"rebuild, setQToFitTransform, setUToFitVelocity", "needs a rebuild", maker<Engine>(How::rebuild)},
            {"Constraint::disable", "foreseen: the pin is constraints, a loop until then", maker<Engine>(How::disable)}};
  }
  if (change == Change::lock) {
    return {{"ConstantCoordinate, solveForConstraintImpulses", "foreseen: declared beforehand", maker<Engine>(How::lock_impulse)},
            {"MobilizedBody::lock", "zeroes the joint's speed", maker<Engine>(How::lock)}};
  }
  return {{"rebuild with Weld, solveForConstraintImpulses", "needs a rebuild", maker<Engine>(How::weld_impulse)},
          {"rebuild with Weld, project", "needs a rebuild; a correction, no impact", maker<Engine>(How::weld_project)}};
}

struct Forward : Evaluator {
  explicit Forward(const EvaluationModel& model)
      : system(model.links, -1),
        forces(system.system),
        fall(forces, system.matter, st::Vec3(0, 0, gravity)),
        first(model.floating() ? 1 : 0) {
    system.state = system.system.realizeTopology();
    system.system.realizeModel(system.state);
    for (st::MobilizedBody& body : system.bodies) {
      places.push_back(body.getFirstQIndex(system.state));
      rows.push_back(body.getFirstUIndex(system.state));
    }
    if (first == 0) return;
    const Link& root = model.links.front();
    system.bodies[0].setQToFitTransform(system.state, st::Transform(mat(root.turn), vec(root.at)));
    system.system.realize(system.state, st::Stage::Position);
    system.bodies[0].setUToFitVelocity(system.state, st::SpatialVec(vec(root.angular), vec(root.linear)));
  }
  void evaluate(const double* from_q, const double* from_u) override {
    st::Vector& q = system.state.updQ();
    for (std::size_t i = first; i < places.size(); ++i) q[places[i]] = from_q[i];
    st::Vector& u = system.state.updU();
    for (std::size_t i = first; i < rows.size(); ++i) u[rows[i]] = from_u[i];
    system.system.realize(system.state, st::Stage::Acceleration);
  }
  std::vector<double> accelerations() override {
    std::vector<double> a;
    for (const int row : rows) a.push_back(system.state.getUDot()[row]);
    if (first == 0) return a;
    a[0] = 0;
    const st::SpatialVec root = system.bodies[0].getBodyAcceleration(system.state);
    for (const st::Vec3& each : {root[1], root[0]}) a.insert(a.end(), &each[0], &each[0] + 3);
    return a;
  }
  System system;
  st::GeneralForceSubsystem forces;
  st::Force::UniformGravity fall;
  std::size_t first;  // the first revolute joint
  std::vector<int> places, rows;
};

}  // namespace

int main(int count, char** words) {
  if (count == 1) return run("Simbody 3.7", ways);
  if (std::string(words[1]) == "loops") return evaluate_loops("Simbody 3.7", loop_ways(), count > 2 ? words[2] : "");
  return evaluate("Simbody 3.7", {{"realize(Acceleration)", evaluator<Forward>()}}, {words + 2, words + count});
}
