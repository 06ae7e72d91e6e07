// RBDL: evaluations only. A model is built once; another topology needs another model.
#include <rbdl/rbdl.h>

#include "evaluation.hpp"

namespace {

namespace rb = RigidBodyDynamics;
using namespace peers;

rb::Math::Vector3d vec(const Vector3d& a) { return {a.x(), a.y(), a.z()}; }

struct Forward : Evaluator {
  explicit Forward(const EvaluationModel& m) : n(m.links.size()), floating(m.floating()) {
    model.gravity = rb::Math::Vector3d(0, 0, gravity);
    const rb::Joint pin(rb::Math::SpatialVector(0, 0, 1, 0, 0, 0)), slide(rb::Math::SpatialVector(0, 0, 0, 0, 0, 1)),
        base(rb::JointTypeFloatingBase);
    std::vector<unsigned> numbers;
    for (const Link& link : m.links) {
      const Matrix3d I = inertia_of(link);
      const rb::Math::Matrix3d inertia(I(0, 0), I(0, 1), I(0, 2), I(1, 0), I(1, 1), I(1, 2), I(2, 0), I(2, 1), I(2, 2));
      const rb::Body body(link.mass, vec(link.com), inertia);
      const Matrix3d& R = link.turn;
      const rb::Math::Matrix3d to_body(R(0, 0), R(1, 0), R(2, 0), R(0, 1), R(1, 1), R(2, 1), R(0, 2), R(1, 2), R(2, 2));
      const rb::Math::SpatialTransform place =
          link.free ? rb::Math::SpatialTransform() : rb::Math::SpatialTransform(to_body, vec(link.at));
      const rb::Joint& joint = link.free ? base : link.slides ? slide : pin;
      numbers.push_back(model.AddBody(link.parent < 0 ? 0 : numbers[link.parent], place, joint, body, link.name));
      places.push_back(static_cast<int>(model.mJoints[numbers.back()].q_index));
    }
    q = rb::Math::VectorNd::Zero(model.q_size);
    u = effort = found = rb::Math::VectorNd::Zero(model.qdot_size);
    if (!floating) return;
    const Link& root = m.links.front();
    turn = root.turn;
    const Eigen::Quaterniond to_world(turn);
    q.head<3>() = root.at;
    model.SetQuaternion(numbers[0], rb::Math::Quaternion(to_world.x(), to_world.y(), to_world.z(), to_world.w()), q);
    u.head<3>() = root.linear;
    u.segment<3>(3) = turn.transpose() * root.angular;
  }
  void evaluate(const double* from_q, const double* from_u) override {
    for (std::size_t i = floating ? 1 : 0; i < n; ++i) q[places[i]] = from_q[i], u[places[i]] = from_u[i];
    rb::ForwardDynamics(model, q, u, effort, found);
  }
  std::vector<double> accelerations() override {
    std::vector<double> a;
    for (const int place : places) a.push_back(found[place]);
    if (!floating) return a;
    a[0] = 0;
    const Vector3d angular = turn * Vector3d(found.segment<3>(3));  // translations in world axes, rotations in body axes
    a.insert(a.end(), found.data(), found.data() + 3);
    a.insert(a.end(), angular.data(), angular.data() + 3);
    return a;
  }
  rb::Model model;
  std::size_t n;
  bool floating;
  Matrix3d turn;
  rb::Math::VectorNd q, u, effort, found;
  std::vector<int> places;
};

}  // namespace

int main(int count, char** words) {
  if (count == 1) return 0;  // it has no changes to measure
  return evaluate("RBDL", {{"ForwardDynamics", evaluator<Forward>()}}, {words + 2, words + count});
}
