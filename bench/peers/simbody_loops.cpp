// Simbody with closed loops as constraints. A planar mechanism needs two of a ball's three equations.
#include <memory>

#include "loops.hpp"
#include "simbody_system.hpp"

namespace {

using namespace peers;

struct Loops : LoopEvaluator {
  Loops(const LoopModel& model, bool planes)
      : system(model.links, -1), forces(system.system), fall(forces, system.matter, st::Vec3(0, 0, gravity)) {
    for (const LoopJoint& loop : model.loops) {
      st::MobilizedBody& one = system.bodies[static_cast<std::size_t>(loop.body)];
      st::MobilizedBody& two = loop.to < 0 ? static_cast<st::MobilizedBody&>(system.matter.updGround())
                                           : system.bodies[static_cast<std::size_t>(loop.to)];
      if (!model.planar) {
        st::Constraint::Weld(two, st::Transform(mat(loop.to_turn), vec(loop.to_at)), one,
                             st::Transform(mat(loop.turn), vec(loop.at)));
      } else if (!planes) {
        st::Constraint::Ball(two, vec(loop.to_at), one, vec(loop.at));
      } else {
        for (int k = 0; k < 2; ++k) {
          const Vector3d normal = loop.to_turn.col(k);
          st::Constraint::PointInPlane(two, st::UnitVec3(vec(normal)), normal.dot(loop.to_at), one, vec(loop.at));
        }
      }
    }
    system.state = system.system.realizeTopology();
    system.system.realizeModel(system.state);
    first = model.floating() ? 1 : 0;
    for (int k = 0; k < 2; ++k) {
      const LoopState& from = model.states[k];
      for (std::size_t i = first; i < model.links.size(); ++i)
        system.bodies[i].setOneQ(system.state, 0, from.q[i]), system.bodies[i].setOneU(system.state, 0, from.u[i]);
      if (first > 0) {
        system.bodies[0].setQToFitTransform(system.state, st::Transform(mat(from.root.R), vec(from.root.p)));
        system.system.realize(system.state, st::Stage::Position);
        system.bodies[0].setUToFitVelocity(system.state, st::SpatialVec(vec(from.root.w), vec(from.root.v)));
      }
      q[k] = system.state.getQ(), u[k] = system.state.getU();
    }
    for (st::MobilizedBody& body : system.bodies) rows.push_back(body.getFirstUIndex(system.state));
  }
  void evaluate(int k) override {
    system.state.updQ() = q[k];
    system.state.updU() = u[k];
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
  std::size_t first;
  st::Vector q[2], u[2];
  std::vector<int> rows;
};

}  // namespace

std::vector<LoopWay> peers::loop_ways() {
  return {{"realize(Acceleration), Ball or Weld", loop_evaluator<Loops>(false)},
          {"realize(Acceleration), two PointInPlane", loop_evaluator<Loops>(true), [](const LoopModel& m) { return m.planar; }}};
}
