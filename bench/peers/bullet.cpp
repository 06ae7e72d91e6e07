// Bullet, in double precision and without damping. The links of a btMultiBody are fixed at its creation: a break needs two new
// ones with the state copied; among btRigidBodies joints are constraints, and a break is removeConstraint. Locks and captures are
// constraints that the (iterative) solver satisfies with impulses in the next step: btMultiBodyJointMotor,
// btMultiBodyFixedConstraint.
#include <algorithm>
#include <cstdlib>
#include <numeric>

#include <BulletDynamics/Featherstone/btMultiBodyFixedConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include "bullet_tree.hpp"
#include "evaluation.hpp"
#include "measure.hpp"

namespace {

using namespace peers;

/// In reduced coordinates; `iterations` of the constraint solver, 10 by default in Bullet.
struct Reduced : Trial {
  Reduced(const Experiment& experiment, double h, int iterations) : e(experiment), step(h) {
    const std::vector<Motion> motions = start(e);
    for (int i = 0; i < static_cast<int>(e.links.size()); ++i) {
      if (e.links[i].parent < 0) trees.push_back(std::make_unique<Tree>(e.links, subtree(e.links, i)));
    }
    for (const auto& tree : trees) {
      for (const int body : tree->numbers) {
        const int i = tree->link_of(body);
        if (i < 0) tree->set_base(motions[body], e.links[body]);
        if (i >= 0) tree->mb->setJointPos(i, e.links[body].angle), tree->mb->setJointVel(i, e.links[body].rate);
      }
      tree->refresh();
      world.bullet.addMultiBody(tree->mb.get());
      if (e.change != Change::cut) add_colliders(*tree);
    }
    world.bullet.getSolverInfo().m_numIterations = iterations;
  }
  ~Reduced() override {
    if (constraint) world.bullet.removeMultiBodyConstraint(constraint.get());
    for (const auto& collider : colliders) world.bullet.removeCollisionObject(collider.get());
    for (const auto& tree : trees) world.bullet.removeMultiBody(tree->mb.get());
  }
  /// Without shapes: constraints are only solved for bodies that have a collider.
  void add_colliders(Tree& tree) {
    for (int i = -1; i < tree.mb->getNumLinks(); ++i) {
      colliders.push_back(std::make_unique<btMultiBodyLinkCollider>(tree.mb.get(), i));
      btMultiBodyLinkCollider* const collider = colliders.back().get();
      collider->setCollisionShape(&shape);
      collider->setActivationState(DISABLE_DEACTIVATION);
      if (i < 0) tree.mb->setBaseCollider(collider);
      if (i >= 0) tree.mb->getLink(i).m_collider = collider;
      world.bullet.addCollisionObject(collider, 1, 0);
    }
  }

  Tree& tree_of(int body) {
    for (const auto& tree : trees) {
      if (std::find(tree->numbers.begin(), tree->numbers.end(), body) != tree->numbers.end()) return *tree;
    }
    std::abort();
  }

  void change() override {
    if (e.change == Change::cut) return rebuild();
    Tree& tree = tree_of(e.body);
    if (e.change == Change::lock) {
      constraint = std::make_unique<btMultiBodyJointMotor>(tree.mb.get(), tree.link_of(e.body), 0.0, BT_LARGE_FLOAT);
    } else {
      const std::vector<Motion> all = motions();
      const Motion &hand = all[e.to], &held = all[e.body];
      const Matrix3d R = hand.R.transpose() * held.R;
      const Vector3d pivot = hand.R.transpose() * (held.p - centre(e.links[e.to], hand));
      Tree& tug = tree_of(e.to);
      constraint = std::make_unique<btMultiBodyFixedConstraint>(
          tug.mb.get(), tug.link_of(e.to), tree.mb.get(), tree.link_of(e.body), vec(pivot), vec(Vector3d(-e.links[e.body].com)),
          mat(R), btMatrix3x3::getIdentity());
    }
    constraint->finalizeMultiDof();
    world.bullet.addMultiBodyConstraint(constraint.get());
    world.bullet.stepSimulation(step, 0);
  }
  /// Replaces one tree by two.
  void rebuild() {
    const std::vector<Motion> all = motions();
    const std::unique_ptr<Tree> old = std::move(trees[0]);
    std::vector<Link> links = e.links;
    links[e.body].parent = -1, links[e.body].free = true;
    world.bullet.removeMultiBody(old->mb.get());
    trees.clear();
    for (const int root : {old->numbers[0], e.body}) {
      trees.push_back(std::make_unique<Tree>(links, subtree(links, root)));
      Tree& tree = *trees.back();
      for (const int body : tree.numbers) {
        const int i = tree.link_of(body), was = old->link_of(body);
        if (i < 0) tree.set_base(all[body], links[body]);
        if (i >= 0) tree.mb->setJointPos(i, old->mb->getJointPos(was)), tree.mb->setJointVel(i, old->mb->getJointVel(was));
      }
      tree.refresh();
      world.bullet.addMultiBody(tree.mb.get());
    }
  }
  double elapsed() const override { return step; }

  std::vector<Motion> motions() override {
    std::vector<Motion> all(e.links.size());
    for (const auto& tree : trees) tree->refresh(), tree->read(e.links, all);
    return all;
  }

  Experiment e;
  double step;
  World world;
  std::vector<std::unique_ptr<Tree>> trees;
  std::unique_ptr<btMultiBodyConstraint> constraint;
  btEmptyShape shape;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
};

/// Rigid bodies with hinges, in maximal coordinates.
struct Maximal : Trial {
  explicit Maximal(const Experiment& experiment) : e(experiment) {
    const std::vector<Motion> motions = start(e);
    for (std::size_t i = 0; i < e.links.size(); ++i) {
      const Link& link = e.links[i];
      bodies.push_back(std::make_unique<btRigidBody>(link.mass, nullptr, &shape, vec(link.inertia)));
      btRigidBody& body = *bodies.back();
      body.setCenterOfMassTransform(btTransform(mat(motions[i].R), vec(centre(link, motions[i]))));
      body.setLinearVelocity(vec(centre_velocity(link, motions[i])));
      body.setAngularVelocity(vec(motions[i].w));
      world.bullet.addRigidBody(&body);
      const btVector3 pivot = vec(Vector3d(-link.com)), z(0, 0, 1);
      if (link.parent < 0) {
        hinges.push_back(std::make_unique<btHingeConstraint>(body, pivot, z));
      } else {
        const Vector3d at = link.at - e.links[link.parent].com;
        hinges.push_back(
            std::make_unique<btHingeConstraint>(*bodies[link.parent], body, vec(at), pivot, vec(Vector3d(link.turn.col(2))), z));
      }
      world.bullet.addConstraint(hinges.back().get());
    }
  }
  ~Maximal() override {
    for (const auto& hinge : hinges) world.bullet.removeConstraint(hinge.get());
    for (const auto& body : bodies) world.bullet.removeRigidBody(body.get());
  }
  void change() override { world.bullet.removeConstraint(hinges[e.body].get()); }
  std::vector<Motion> motions() override {
    std::vector<Motion> all;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const btRigidBody& b = *bodies[i];
      all.push_back(from_centre(e.links[i], mat(b.getWorldTransform().getBasis()), vec(b.getCenterOfMassPosition()),
                                vec(b.getLinearVelocity()), vec(b.getAngularVelocity())));
    }
    return all;
  }
  Experiment e;
  World world;
  btEmptyShape shape;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<std::unique_ptr<btHingeConstraint>> hinges;
};

std::vector<Way> ways(Change change) {
  if (change == Change::cut) {
    return {{"rebuild two btMultiBodies, copy the state", "needs a rebuild", maker<Reduced>(0.0, 10)},
            {"removeConstraint between btRigidBodies", "maximal coordinates: joints drift before", maker<Maximal>()}};
  }
  const std::string name = change == Change::lock ? "btMultiBodyJointMotor" : "btMultiBodyFixedConstraint";
  return {{name + ", step of 1 µs", "10 iterations, the default", maker<Reduced>(1e-6, 10)},
          {name + ", step of 1 µs, 1000 iterations", "", maker<Reduced>(1e-6, 1000)},
          {name + ", step of 1 ms", "10 iterations, a usual step", maker<Reduced>(1e-3, 10)}};
}

struct Forward : Evaluator {
  explicit Forward(const EvaluationModel& m)
      : model(m), tree(model.links, every(model.links)), n(tree.mb->getNumLinks()), found(model.links.size()) {
    tree.mb->setMaxCoordinateVelocity(1e30);
    for (const Link& link : model.links) weights.push_back(btVector3(0, 0, gravity * link.mass));
    const Link& root = model.links.front();
    at_start = {root.turn, root.at, root.linear, root.angular};
    omega = vec(root.angular), velocity = vec(centre_velocity(root, at_start));
    if (m.floating()) tree.set_base(at_start, root);
  }
  static std::vector<int> every(const std::vector<Link>& links) {
    std::vector<int> all(links.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
  }
  void evaluate(const double* q, const double* u) override {
    btMultiBody& mb = *tree.mb;
    const int first = tree.first;
    if (first > 0) mb.setBaseVel(velocity), mb.setBaseOmega(omega);
    for (int i = 0; i < n; ++i) mb.setJointPos(i, q[i + first]), mb.setJointVel(i, u[i + first]);
    mb.clearForcesAndTorques();
    if (first > 0) mb.addBaseForce(weights[0]);
    for (int i = 0; i < n; ++i) mb.addLinkForce(i, weights[i + first]);
    mb.computeAccelerationsArticulatedBodyAlgorithmMultiDof(1, scalars, vectors, matrices, false, false,
                                                            false);  // adds 1 s of it
    for (int i = 0; i < n; ++i) found[i + first] = mb.getJointVel(i) - u[i + first];
  }
  std::vector<double> accelerations() override {
    std::vector<double> a = found;
    if (tree.first == 0) return a;
    const Vector3d w = at_start.w, arm = at_start.R * model.links[0].com;
    const Vector3d centre = vec(tree.mb->getBaseVel() - velocity), angular = vec(tree.mb->getBaseOmega() - omega);
    const Vector3d linear = centre - angular.cross(arm) - w.cross(w.cross(arm));
    for (const Vector3d& each : {linear, angular}) a.insert(a.end(), each.data(), each.data() + 3);
    return a;
  }
  EvaluationModel model;
  Tree tree;
  int n;
  Motion at_start;
  btVector3 omega, velocity;
  std::vector<double> found;
  std::vector<btVector3> weights;
  btAlignedObjectArray<btScalar> scalars;
  btAlignedObjectArray<btVector3> vectors;
  btAlignedObjectArray<btMatrix3x3> matrices;
};

}  // namespace

int main(int count, char** words) {
  const std::string name = "Bullet " + std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
  if (count == 1) return run(name, ways);
  return evaluate(name, {{"btMultiBody, articulated bodies", evaluator<Forward>()}}, {words + 2, words + count});
}
