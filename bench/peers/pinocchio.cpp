// Pinocchio. A model is built once; another topology needs another model, whose state the caller copies. buildReducedModel makes
// a model without some joints. impulseDynamics computes an impact.
#include <algorithm>
#include <string>

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/contact-dynamics.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/model.hpp>

#include "evaluation.hpp"
#include "loops.hpp"
#include "measure.hpp"
#include "pinocchio_model.hpp"

namespace {

using namespace peers;

enum class How { rebuild, impact, impact_and_rebuild, reduce, impact_and_reduce };

struct Engine : Trial {
  Engine(const Experiment& experiment, How way) : e(experiment), how(way), links(e.links), now(std::make_unique<Model>(links)) {
    for (int i = 0; i < static_cast<int>(links.size()); ++i) {
      const Link& link = links[i];
      if (link.free) now->put(i, {link.turn, link.at, link.linear, link.angular});
      if (!link.free) now->put(i, link.angle, link.rate);
    }
    move();
  }
  void move() { pin::forwardKinematics(now->model, *now->data, now->q, now->u); }

  void change() override {
    if (how != How::rebuild && how != How::reduce) impact();
    if (how == How::rebuild || how == How::impact_and_rebuild) rebuild();
    if (how == How::reduce || how == How::impact_and_reduce) reduce();
    move();
  }

  /// The velocities that become zero are given by their Jacobian. (A RigidConstraintModel between two bodies does not say the
  /// same here: of these, version 4.1 stops only the first one.)
  void impact() {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(e.change == Change::lock ? 1 : 6, now->model.nv);
    if (e.change == Change::lock) {
      J(0, now->row(e.body)) = 1;
    } else {  // the velocity of the body relative to the hand, in the body's frame
      const Motion hand = now->read(e.to), held = now->read(e.body);
      const pin::SE3 relative(hand.R.transpose() * held.R, hand.R.transpose() * (held.p - hand.p));
      Eigen::MatrixXd of_hand = J;
      pin::computeJointJacobians(now->model, *now->data, now->q);
      pin::getJointJacobian(now->model, *now->data, now->numbers[e.body], pin::LOCAL, J);
      pin::getJointJacobian(now->model, *now->data, now->numbers[e.to], pin::LOCAL, of_hand);
      J -= relative.toActionMatrixInverse() * of_hand;
    }
    PINOCCHIO_COMPILER_DIAGNOSTIC_PUSH
    PINOCCHIO_COMPILER_DIAGNOSTIC_IGNORED_DEPRECECATED_DECLARATIONS
    now->u = pin::impulseDynamics(now->model, *now->data, now->q, now->u, J);
    PINOCCHIO_COMPILER_DIAGNOSTIC_POP
    move();
  }

  /// Another model, whose joints get the state of the joints that had the same bodies.
  void rebuild() {
    Link& link = links[e.body];
    const Motion held = now->read(e.body);
    if (e.change == Change::cut) link.parent = -1, link.free = true;
    if (e.change == Change::capture) {
      const Motion hand = now->read(e.to);
      link.parent = e.to, link.free = false;
      link.turn = hand.R.transpose() * held.R, link.at = hand.R.transpose() * (held.p - hand.p);
    }
    auto next = std::make_unique<Model>(links, e.change == Change::capture ? e.body : -1);
    for (int i = 0; i < static_cast<int>(links.size()); ++i) {
      if (i == e.body) continue;
      const auto& joint = next->model.joints[next->numbers[i]];
      next->q.segment(next->place(i), joint.nq()) = now->q.segment(now->place(i), joint.nq());
      next->u.segment(next->row(i), joint.nv()) = now->u.segment(now->row(i), joint.nv());
    }
    if (e.change == Change::cut) next->put(e.body, held);
    now = std::move(next);
  }

  /// The model without the joint, which becomes a part of its parent's.
  void reduce() {
    const pin::JointIndex locked = now->numbers[e.body], parent = now->model.parents[locked];
    const pin::SE3 place = now->data->liMi[locked];
    const int at_q = now->place(e.body), at_u = now->row(e.body);
    pin::Model reduced;
    pin::buildReducedModel(now->model, {locked}, now->q, reduced);
    const auto without = [](const Eigen::VectorXd& all, int index) {
      Eigen::VectorXd rest(all.size() - 1);
      rest << all.head(index), all.tail(all.size() - index - 1);
      return rest;
    };
    now->q = without(now->q, at_q), now->u = without(now->u, at_u);
    now->model = std::move(reduced);
    now->data = std::make_unique<pin::Data>(now->model);
    for (pin::JointIndex& number : now->numbers) number -= number > locked ? 1 : 0;
    now->numbers[e.body] = parent, now->frames[e.body] = place;
  }

  std::vector<Motion> motions() override {
    std::vector<Motion> all;
    for (int i = 0; i < static_cast<int>(links.size()); ++i) all.push_back(now->read(i));
    return all;
  }

  Experiment e;
  How how;
  std::vector<Link> links;
  std::unique_ptr<Model> now;
};

std::vector<Way> ways(Change change) {
  if (change == Change::cut) return {{"rebuild, copy the state", "needs a rebuild", maker<Engine>(How::rebuild)}};
  if (change == Change::lock) {
    return {{"impulseDynamics, buildReducedModel", "needs a rebuild", maker<Engine>(How::impact_and_reduce)},
            {"impulseDynamics", "the same, the model is kept: its constraint must be enforced", maker<Engine>(How::impact)},
            {"buildReducedModel, copy the rest", "needs a rebuild; zeroes the joint's speed", maker<Engine>(How::reduce)}};
  }
  return {{"impulseDynamics, rebuild as part of the hand", "needs a rebuild", maker<Engine>(How::impact_and_rebuild)},
          {"impulseDynamics", "the same, the model is kept: its constraint must be enforced", maker<Engine>(How::impact)},
          {"rebuild as part of the hand, copy the rest", "needs a rebuild; takes on the hand's velocity",
           maker<Engine>(How::rebuild)}};
}

struct Forward : Evaluator {
  explicit Forward(const EvaluationModel& m) : first(m.floating() ? 1 : 0), count(m.links.size()), model(m.links) {
    model.model.gravity.linear(Vector3d(0, 0, gravity));
    effort = Eigen::VectorXd::Zero(model.model.nv);
    for (std::size_t i = 0; i < count; ++i) {
      places.push_back(model.place(static_cast<int>(i))), rows.push_back(model.row(static_cast<int>(i)));
    }
    const Link& root = m.links.front();
    turn = root.turn;
    if (root.free) model.put(0, {root.turn, root.at, root.linear, root.angular});
  }
  void evaluate(const double* q, const double* u) override {
    for (std::size_t i = first; i < count; ++i) model.q[places[i]] = q[i], model.u[rows[i]] = u[i];
    pin::aba(model.model, *model.data, model.q, model.u, effort, pin::Convention::WORLD);
  }
  std::vector<double> accelerations() override {
    const Eigen::VectorXd& found = model.data->ddq;
    std::vector<double> a;
    for (const int row : rows) a.push_back(found[row]);
    if (first == 0) return a;
    a[0] = 0;
    const Vector3d v = model.u.head<3>(), w = model.u.segment<3>(3), rate = found.head<3>();
    const Vector3d linear = turn * (rate + w.cross(v)), angular = turn * found.segment<3>(3);
    for (const Vector3d& each : {linear, angular}) a.insert(a.end(), each.data(), each.data() + 3);
    return a;
  }
  std::size_t first, count;
  Model model;
  Eigen::VectorXd effort;
  Matrix3d turn;
  std::vector<int> places, rows;
};

}  // namespace

int main(int argc, char** words) {
  if (argc == 1) return run("Pinocchio " PINOCCHIO_VERSION, ways);
  if (std::string(words[1]) == "loops")
    return evaluate_loops("Pinocchio " PINOCCHIO_VERSION, loop_ways(), argc > 2 ? words[2] : "");
  Evaluation way{"aba", evaluator<Forward>()};
  way.most = 100;  // its data for 1000 bodies need 32 GB, including matrices that are not used here
  return evaluate("Pinocchio " PINOCCHIO_VERSION, {way}, {words + 2, words + argc});
}
