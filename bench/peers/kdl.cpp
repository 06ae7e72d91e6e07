// KDL: evaluations of chains only. The Vereshchagin solver, without constraints, is its O(n) solver.
#include <kdl/chain.hpp>
#include <kdl/chainhdsolver_vereshchagin.hpp>

#include "evaluation.hpp"

namespace {

using namespace peers;

KDL::Vector vec(const Vector3d& a) { return {a.x(), a.y(), a.z()}; }

KDL::Chain chain_of(const EvaluationModel& model) {
  KDL::Chain chain;
  for (const Link& link : model.links) {
    const Matrix3d& R = link.turn;
    const KDL::Frame frame(KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
                           vec(link.at));
    // It needs the inertia about the centre of mass along the frame's axes; the joint is given in the parent's frame.
    const Matrix3d I = inertia_of(link);
    const KDL::RigidBodyInertia inertia(link.mass, vec(link.com),
                                        KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
    const KDL::Joint::JointType type = link.slides ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
    chain.addSegment(KDL::Segment(link.name, KDL::Joint(link.name, frame.p, frame.M.UnitZ(), type), frame, inertia));
  }
  return chain;
}

struct Forward : Evaluator {
  explicit Forward(const EvaluationModel& model)
      : chain(chain_of(model)),
        n(static_cast<unsigned>(model.links.size())),
        solver(chain, KDL::Twist(KDL::Vector(0, 0, -gravity), KDL::Vector::Zero()), 1),
        q(n),
        u(n),
        found(n),
        effort(n),
        constraint_effort(n),
        forces(n, KDL::Wrench::Zero()),
        directions(1),
        accelerations_along(1) {
    SetToZero(directions);
    SetToZero(accelerations_along);
  }
  void evaluate(const double* from_q, const double* from_u) override {
    for (unsigned i = 0; i < n; ++i) q(i) = from_q[i], u(i) = from_u[i], effort(i) = 0;
    solver.CartToJnt(q, u, found, directions, accelerations_along, forces, effort, constraint_effort);
  }
  std::vector<double> accelerations() override {
    std::vector<double> a(n);
    for (unsigned i = 0; i < n; ++i) a[i] = found(i);
    return a;
  }
  KDL::Chain chain;
  unsigned n;
  KDL::ChainHdSolver_Vereshchagin solver;
  KDL::JntArray q, u, found, effort, constraint_effort;
  KDL::Wrenches forces;
  KDL::Jacobian directions;
  KDL::JntArray accelerations_along;
};

}  // namespace

int main(int count, char** words) {
  if (count == 1) return 0;  // it has no changes to measure
  Evaluation way{"ChainHdSolver_Vereshchagin", evaluator<Forward>()};
  way.chains_only = true;
  return evaluate("KDL " KDL_VERSION, {way}, {words + 2, words + count});
}
