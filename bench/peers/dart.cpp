// DART. Skeletons can be split and grafted at run time, which keeps poses and velocities of the remaining joints; the state of a
// new joint must be set by the caller: setTransform and setSpatialVelocity, as simulators based on DART do. Joints are locked by
// their actuator type, or held with impulses by the constraint solver (SERVO, WeldJointConstraint) in the next step.
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/constraint/WeldJointConstraint.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>

#include "evaluation.hpp"
#include "measure.hpp"

namespace {

namespace dd = dart::dynamics;
using namespace peers;

enum class How { split, split_and_set, locked, servo, weld_constraint, move_to };

struct Engine : Trial {
  Engine(const Experiment& experiment, How way, double h) : e(experiment), how(way), step(h) {
    world->setGravity(Vector3d::Zero());
    world->setTimeStep(step > 0 ? step : 1e-3);
    for (const Link& link : e.links) add(link);
  }

  void add(const Link& link) {
    dd::BodyNode::Properties body;
    body.mName = link.name;
    body.mInertia.setMass(link.mass);
    body.mInertia.setLocalCOM(link.com);
    body.mInertia.setMoment(link.inertia.x(), link.inertia.y(), link.inertia.z(), 0, 0, 0);
    dd::BodyNode* parent = link.parent < 0 ? nullptr : nodes[link.parent];
    dd::SkeletonPtr skeleton = parent != nullptr ? parent->getSkeleton() : dd::Skeleton::create(link.name);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = link.turn;
    pose.translation() = link.at;
    if (link.free) {
      const auto [joint, node] = skeleton->createJointAndBodyNodePair<dd::FreeJoint>(parent, {}, body);
      nodes.push_back(node);
      joint->setTransform(pose);
      joint->setSpatialVelocity((Eigen::Vector6d() << link.angular, link.linear).finished(), dd::Frame::World(),
                                dd::Frame::World());
    } else {
      dd::RevoluteJoint::Properties pin;
      pin.mName = link.name;
      pin.mAxis = Vector3d::UnitZ();
      pin.mT_ParentBodyToJoint = pose;
      const auto [joint, node] = skeleton->createJointAndBodyNodePair<dd::RevoluteJoint>(parent, pin, body);
      nodes.push_back(node);
      joint->setPosition(0, link.angle);
      joint->setVelocity(0, link.rate);
    }
    if (parent == nullptr) world->addSkeleton(skeleton);
  }

  void change() override {
    dd::BodyNode* body = nodes[e.body];
    dd::Joint* joint = body->getParentJoint();
    if (how == How::split || how == How::split_and_set) {
      const Eigen::Isometry3d pose = body->getTransform();
      const Eigen::Vector6d velocity = body->getSpatialVelocity(dd::Frame::World(), dd::Frame::World());
      const dd::SkeletonPtr part = body->split<dd::FreeJoint>("part");
      world->addSkeleton(part);
      if (how == How::split_and_set) {
        auto* made = static_cast<dd::FreeJoint*>(body->getParentJoint());
        made->setTransform(pose);
        made->setSpatialVelocity(velocity, dd::Frame::World(), dd::Frame::World());
      }
    }
    if (how == How::locked) joint->setActuatorType(dd::Joint::LOCKED);
    if (how == How::servo) {  // holds still with any force required
      joint->setActuatorType(dd::Joint::SERVO);
      joint->setForceLowerLimit(0, -dart::math::constantsd::inf());
      joint->setForceUpperLimit(0, dart::math::constantsd::inf());
      joint->setCommand(0, 0);
    }
    if (how == How::weld_constraint) {
      world->getConstraintSolver()->addConstraint(std::make_shared<dart::constraint::WeldJointConstraint>(nodes[e.to], body));
    }
    if (how == How::move_to) {
      dd::WeldJoint::Properties weld;
      weld.mName = "weld";
      weld.mT_ParentBodyToJoint = nodes[e.to]->getTransform().inverse() * body->getTransform();
      const dd::SkeletonPtr emptied = body->getSkeleton();
      body->moveTo<dd::WeldJoint>(nodes[e.to], weld);
      world->removeSkeleton(emptied);
    }
    if (step > 0) world->step();
  }
  double elapsed() const override { return step; }

  std::vector<Motion> motions() override {
    std::vector<Motion> all;
    for (const dd::BodyNode* node : nodes) {
      const Eigen::Isometry3d& pose = node->getTransform();
      all.push_back({pose.linear(), pose.translation(), node->getLinearVelocity(), node->getAngularVelocity()});
    }
    return all;
  }

  Experiment e;
  How how;
  double step;
  dart::simulation::WorldPtr world = dart::simulation::World::create();
  std::vector<dd::BodyNode*> nodes;
};

std::vector<Way> ways(Change change) {
  if (change == Change::cut) {
    return {{"split<FreeJoint>, setTransform, setSpatialVelocity", "", maker<Engine>(How::split_and_set, 0.0)},
            {"split<FreeJoint> alone", "the new joint stands at zero, at rest", maker<Engine>(How::split, 0.0)}};
  }
  if (change == Change::lock) {
    return {{"SERVO at speed 0, step of 1 µs", "impulse of the constraint solver", maker<Engine>(How::servo, 1e-6)},
            {"SERVO at speed 0, step of 1 ms", "the same at a usual step", maker<Engine>(How::servo, 1e-3)},
            {"LOCKED, step of 1 µs", "zeroes the joint's speed", maker<Engine>(How::locked, 1e-6)}};
  }
  return {{"WeldJointConstraint, step of 1 µs", "impulse of the constraint solver", maker<Engine>(How::weld_constraint, 1e-6)},
          {"WeldJointConstraint, step of 1 ms", "the same at a usual step", maker<Engine>(How::weld_constraint, 1e-3)},
          {"moveTo<WeldJoint>", "takes on the hand's velocity", maker<Engine>(How::move_to, 0.0)}};
}

struct Forward : Evaluator {
  explicit Forward(const EvaluationModel& model) : floating(model.floating()) {
    skeleton->setGravity(Vector3d(0, 0, gravity));
    for (const Link& link : model.links) {
      dd::BodyNode::Properties body;
      body.mName = link.name;
      body.mInertia.setMass(link.mass);
      body.mInertia.setLocalCOM(link.com);
      body.mInertia.setMoment(inertia_of(link));
      dd::BodyNode* parent = link.parent < 0 ? nullptr : nodes[link.parent];
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.linear() = link.turn;
      pose.translation() = link.at;
      if (link.free) {
        const auto [joint, node] = skeleton->createJointAndBodyNodePair<dd::FreeJoint>(parent, {}, body);
        joint->setTransform(pose);
        joint->setSpatialVelocity((Eigen::Vector6d() << link.angular, link.linear).finished(), dd::Frame::World(),
                                  dd::Frame::World());
        nodes.push_back(node);
        places.push_back(static_cast<int>(joint->getIndexInSkeleton(0)));
        continue;
      }
      if (link.slides) {
        add<dd::PrismaticJoint>(link, parent, pose, body);
      } else {
        add<dd::RevoluteJoint>(link, parent, pose, body);
      }
    }
    q = skeleton->getPositions(), u = skeleton->getVelocities();
  }
  template <class Joint>
  void add(const Link& link, dd::BodyNode* parent, const Eigen::Isometry3d& pose, const dd::BodyNode::Properties& body) {
    typename Joint::Properties along_z;
    along_z.mName = link.name;
    along_z.mAxis = Vector3d::UnitZ();
    along_z.mT_ParentBodyToJoint = pose;
    const auto [joint, node] = skeleton->createJointAndBodyNodePair<Joint>(parent, along_z, body);
    nodes.push_back(node);
    places.push_back(static_cast<int>(joint->getIndexInSkeleton(0)));
  }
  void evaluate(const double* from_q, const double* from_u) override {
    for (std::size_t i = floating ? 1 : 0; i < places.size(); ++i) q[places[i]] = from_q[i], u[places[i]] = from_u[i];
    skeleton->setPositions(q);
    skeleton->setVelocities(u);
    skeleton->computeForwardDynamics();
  }
  std::vector<double> accelerations() override {
    std::vector<double> a;
    for (const int place : places) a.push_back(skeleton->getAcceleration(place));
    if (!floating) return a;
    a[0] = 0;
    const Vector3d linear = nodes[0]->getLinearAcceleration(), angular = nodes[0]->getAngularAcceleration();
    for (const Vector3d& each : {linear, angular}) a.insert(a.end(), each.data(), each.data() + 3);
    return a;
  }
  bool floating;
  std::vector<dd::BodyNode*> nodes;
  dd::SkeletonPtr skeleton = dd::Skeleton::create("model");
  std::vector<int> places;
  Eigen::VectorXd q, u;
};

}  // namespace

int main(int count, char** words) {
  if (count == 1) return run("DART " DART_VERSION, ways);
  return evaluate("DART " DART_VERSION, {{"computeForwardDynamics", evaluator<Forward>()}}, {words + 2, words + count});
}
