#pragma once
// A system of Simbody made from links.
#include <Simbody.h>

#include <vector>

#include "experiment.hpp"

namespace peers {

namespace st = SimTK;

inline st::Vec3 vec(const Vector3d& a) { return {a.x(), a.y(), a.z()}; }
inline Vector3d vec(const st::Vec3& a) { return {a[0], a[1], a[2]}; }
inline st::Rotation mat(const Matrix3d& R) {
  return st::Rotation(st::Mat33(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)), true);
}
inline Matrix3d mat(const st::Rotation& R) {
  Matrix3d m;
  for (int i = 0; i < 3; ++i) m.col(i) = vec(st::Vec3(R.asMat33().col(i)));
  return m;
}

/// The bodies; `loose`: a body that is on a six-DoF mobilizer to the ground, whatever its joint was.
struct System {
  System(const std::vector<Link>& links, int loose) : matter(system) {
    for (int i = 0; i < static_cast<int>(links.size()); ++i) {
      const Link& link = links[i];
      const Matrix3d I = inertia_of(link);
      const st::Inertia inertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
      const st::MassProperties mass(link.mass, vec(link.com), inertia.shiftFromMassCenter(vec(link.com), link.mass));
      st::MobilizedBody& parent = link.parent < 0 ? static_cast<st::MobilizedBody&>(matter.updGround()) : bodies[link.parent];
      free.push_back(link.free || i == loose);
      if (free.back()) {
        bodies.push_back(st::MobilizedBody::Free(matter.updGround(), st::Body::Rigid(mass)));
      } else {
        const st::Transform frame(mat(link.turn), vec(link.at));
        if (link.slides) {  // along x there
          const st::Transform along(st::Rotation(-st::Pi / 2, st::YAxis));
          bodies.push_back(st::MobilizedBody::Slider(parent, frame * along, st::Body::Rigid(mass), along));
        } else {
          bodies.push_back(st::MobilizedBody::Pin(parent, frame, st::Body::Rigid(mass), st::Transform()));
        }
      }
    }
  }
  void start(const Experiment& e) {
    state = system.realizeTopology();
    const std::vector<Motion> motions = peers::start(e);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (free[i]) bodies[i].setQToFitTransform(state, st::Transform(mat(motions[i].R), vec(motions[i].p)));
      if (!free[i]) bodies[i].setOneQ(state, 0, e.links[i].angle), bodies[i].setOneU(state, 0, e.links[i].rate);
    }
    system.realize(state, st::Stage::Position);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (free[i]) bodies[i].setUToFitVelocity(state, st::SpatialVec(vec(motions[i].w), vec(motions[i].v)));
    }
    system.realize(state, st::Stage::Velocity);
  }
  /// Copies the state of a system of the same bodies.
  void copy(const System& from) {
    state = system.realizeTopology();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (free[i] == from.free[i]) bodies[i].setQFromVector(state, from.bodies[i].getQAsVector(from.state));
      if (free[i] != from.free[i]) bodies[i].setQToFitTransform(state, from.bodies[i].getBodyTransform(from.state));
    }
    system.realize(state, st::Stage::Position);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (free[i] == from.free[i]) bodies[i].setUFromVector(state, from.bodies[i].getUAsVector(from.state));
      if (free[i] != from.free[i]) bodies[i].setUToFitVelocity(state, from.bodies[i].getBodyVelocity(from.state));
    }
    system.realize(state, st::Stage::Velocity);
  }
  /// The impact of the enabled constraints, as documented for solveForConstraintImpulses.
  void impact() {
    system.realize(state, st::Stage::Velocity);
    st::Vector impulse, f, du;
    matter.solveForConstraintImpulses(state, -state.getUErr(), impulse);
    matter.multiplyByGTranspose(state, impulse, f);
    matter.multiplyByMInv(state, f, du);
    state.updU() += du;
    system.realize(state, st::Stage::Velocity);
  }

  st::MultibodySystem system;
  st::SimbodyMatterSubsystem matter;
  std::vector<st::MobilizedBody> bodies;
  std::vector<bool> free;
  st::State state;
};

}  // namespace peers
