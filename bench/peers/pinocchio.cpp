// Pinocchio: evaluations only. A model is built once; another topology needs another model.
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>

#include "evaluation.hpp"

namespace {

namespace pin = pinocchio;
using namespace peers;

struct Forward : Evaluator {
  explicit Forward(const EvaluationModel& m) : floating(m.floating()) {
    model.gravity.linear(Vector3d(0, 0, gravity));
    std::vector<pin::JointIndex> numbers;
    for (const Link& link : m.links) {
      const pin::JointIndex parent = link.parent < 0 ? 0 : numbers[link.parent];
      const pin::SE3 place = link.free ? pin::SE3::Identity() : pin::SE3(link.turn, link.at);
      numbers.push_back(link.free     ? model.addJoint(parent, pin::JointModelFreeFlyer(), place, link.name)
                        : link.slides ? model.addJoint(parent, pin::JointModelPZ(), place, link.name)
                                      : model.addJoint(parent, pin::JointModelRZ(), place, link.name));
      model.appendBodyToJoint(numbers.back(), pin::Inertia(link.mass, link.com, inertia_of(link)), pin::SE3::Identity());
      places.push_back(model.joints[numbers.back()].idx_q());
      rows.push_back(model.joints[numbers.back()].idx_v());
    }
    data = std::make_unique<pin::Data>(model);
    q = Eigen::VectorXd::Zero(model.nq);
    u = effort = Eigen::VectorXd::Zero(model.nv);
    if (!floating) return;
    const Link& root = m.links.front();
    turn = root.turn;
    q.head<3>() = root.at;
    q.segment<4>(3) = Eigen::Quaterniond(root.turn).coeffs();
    u.head<3>() = root.turn.transpose() * root.linear;
    u.segment<3>(3) = root.turn.transpose() * root.angular;
  }
  void evaluate(const double* from_q, const double* from_u) override {
    for (std::size_t i = floating ? 1 : 0; i < places.size(); ++i) q[places[i]] = from_q[i], u[rows[i]] = from_u[i];
    pin::aba(model, *data, q, u, effort, pin::Convention::WORLD);
  }
  std::vector<double> accelerations() override {
    std::vector<double> a;
    for (const int row : rows) a.push_back(data->ddq[row]);
    if (!floating) return a;
    a[0] = 0;
    const Vector3d v = u.head<3>(), w = u.segment<3>(3), rate = data->ddq.head<3>();
    const Vector3d linear = turn * (rate + w.cross(v)), angular = turn * data->ddq.segment<3>(3);
    for (const Vector3d& each : {linear, angular}) a.insert(a.end(), each.data(), each.data() + 3);
    return a;
  }
  bool floating;
  pin::Model model;
  std::unique_ptr<pin::Data> data;
  Eigen::VectorXd q, u, effort;
  Matrix3d turn;
  std::vector<int> places, rows;
};

}  // namespace

int main(int count, char** words) {
  if (count == 1) return 0;  // it has no changes to measure
  Evaluation way{"aba", evaluator<Forward>()};
  way.most = 100;  // its data for 1000 bodies need 32 GB, including matrices that are not used here
  return evaluate("Pinocchio " PINOCCHIO_VERSION, {way}, {words + 2, words + count});
}
