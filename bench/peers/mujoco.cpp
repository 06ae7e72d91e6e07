// MuJoCo. The topology of a compiled model is fixed; joints that are made or broken at run time are equality constraints,
// declared in advance and switched by eq_active. Constraints are soft by design (here with the default solref, 0.02 s, critically
// damped), so that an activated constraint needs time to act: its result is evaluated 0.3 s later (without gravity and damping,
// energy and momenta are conserved until then), integrated by RK4 as recommended if energy matters. Unforeseen changes need
// another model with the state copied.
#include <algorithm>

#include "evaluation.hpp"
#include "measure.hpp"
#include "mujoco_model.hpp"

namespace {

using namespace peers;

enum class How { rebuild, connects, equality };
constexpr double settling = 0.3;

struct Engine : Trial {
  Engine(const Experiment& experiment, How way) : e(experiment), how(way), links(e.links) {
    std::ostringstream equality;
    const Link& link = links[e.body];
    if (how == How::connects) {  // the revolute joint that will break: two points on the axis of a loose body are constrained
      const std::string between = "body1='" + link.name + "' body2='" + links[link.parent].name + "' anchor='";
      equality << "<connect " << between << "0 0 0'/><connect " << between << "0 0 0.1'/>";
      loosen(start(e)[e.body]);
    }
    if (how == How::equality && e.change == Change::lock) equality << "<joint joint1='" << link.name << "' active='false'/>";
    if (how == How::equality && e.change == Change::capture)
      equality << "<weld body1='" << links[e.to].name << "' body2='" << link.name << "' active='false'/>";
    now = std::make_unique<Model>(links, -1, equality.str());
    for (const Link& each : links) {
      if (each.free) put(*now, each, {each.turn, each.at, each.linear, each.angular});
      if (!each.free) *now->q(each) = each.angle, *now->v(each) = each.rate;
    }
    mj_forward(now->model, now->data);
  }

  static void put(const Model& m, const Link& link, const Motion& motion) {
    const Eigen::Quaterniond q(motion.R);
    const Vector3d w = motion.R.transpose() * motion.w;
    for (int k = 0; k < 3; ++k) m.q(link)[k] = motion.p[k], m.v(link)[k] = motion.v[k], m.v(link)[3 + k] = w[k];
    m.q(link)[3] = q.w(), m.q(link)[4] = q.x(), m.q(link)[5] = q.y(), m.q(link)[6] = q.z();
  }
  void loosen(const Motion& motion) {
    Link& link = links[e.body];
    link.parent = -1, link.free = true;
    link.turn = motion.R, link.at = motion.p, link.linear = motion.v, link.angular = motion.w;
  }

  void change() override {
    mjModel* model = now->model;
    mjData* data = now->data;
    if (how == How::rebuild) return rebuild();
    if (how == How::connects) model->eq_active[0] = model->eq_active[1] = 0;
    if (how == How::equality && e.change == Change::lock) {
      model->eq_data[0] = *now->q(links[e.body]);  // the constant of the polynomial
      model->eq_active[0] = 1;
    }
    if (how == How::equality && e.change == Change::capture) {
      const Motion hand = read(e.to), held = read(e.body);
      const Vector3d p = hand.R.transpose() * (held.p - hand.p);
      const Eigen::Quaterniond q(Matrix3d(hand.R.transpose() * held.R));
      const double relative[] = {0, 0, 0, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), 1};
      // anchor (in body2), pose of body2 in body1, weight of the torques
      std::copy(relative, relative + 11, model->eq_data);
      model->eq_active[0] = 1;
    }
    mj_forward(model, data);
  }
  void settle() override {
    if (how != How::equality) return;
    while (now->data->time < settling) mj_step(now->model, now->data), time = now->data->time;
    mj_forward(now->model, now->data);
  }
  double elapsed() const override { return time; }

  /// Another model, whose joints get the state of the joints with the same names.
  void rebuild() {
    Link& link = links[e.body];
    int fixed = -1;
    if (e.change == Change::cut) loosen(read(e.body));
    if (e.change == Change::lock) {  // without the joint: the angle becomes part of the body's pose
      link.turn = link.turn * Eigen::AngleAxisd(*now->q(link), Vector3d::UnitZ()).toRotationMatrix();
      fixed = e.body;
    }
    if (e.change == Change::capture) {
      const Motion hand = read(e.to), held = read(e.body);
      link.parent = e.to, link.free = false, fixed = e.body;
      link.turn = hand.R.transpose() * held.R, link.at = hand.R.transpose() * (held.p - hand.p);
    }
    auto next = std::make_unique<Model>(links, fixed, "");
    for (int i = 0; i < static_cast<int>(links.size()); ++i) {
      if (i == fixed) continue;
      if (i == e.body) {
        put(*next, link, {link.turn, link.at, link.linear, link.angular});
      } else {
        mju_copy(next->q(links[i]), now->q(links[i]), links[i].free ? 7 : 1);
        mju_copy(next->v(links[i]), now->v(links[i]), links[i].free ? 6 : 1);
      }
    }
    now = std::move(next);
    mj_forward(now->model, now->data);
  }

  Motion read(int i) const {
    const int body = now->body(links[i]);
    mjtNum v[6];
    mj_objectVelocity(now->model, now->data, mjOBJ_XBODY, body, v, 0);
    using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    return {Eigen::Map<const Rows>(now->data->xmat + 9 * body), Eigen::Map<const Vector3d>(now->data->xpos + 3 * body),
            Vector3d(v[3], v[4], v[5]), Vector3d(v[0], v[1], v[2])};
  }
  std::vector<Motion> motions() override {
    std::vector<Motion> all;
    for (int i = 0; i < static_cast<int>(links.size()); ++i) all.push_back(read(i));
    return all;
  }

  Experiment e;
  How how;
  std::vector<Link> links;
  std::unique_ptr<Model> now;
  double time = 0;
};

std::vector<Way> ways(Change change) {
  const std::string soft = "foreseen: declared beforehand; soft, judged 0.3 s later, time is of the switching";
  if (change == Change::cut) {
    return {{"rebuild, copy the state", "needs a rebuild", maker<Engine>(How::rebuild)},
            {"two connects, eq_active = 0", "foreseen: the pin is soft constraints until then", maker<Engine>(How::connects)}};
  }
  if (change == Change::lock) {
    return {
        {"joint equality, eq_active = 1", soft, maker<Engine>(How::equality)},
        {"rebuild without the joint, copy the rest", "needs a rebuild; zeroes the joint's speed", maker<Engine>(How::rebuild)}};
  }
  return {{"weld equality, eq_active = 1", soft, maker<Engine>(How::equality)},
          {"rebuild as child of the hand, copy the rest", "needs a rebuild; takes on the hand's velocity",
           maker<Engine>(How::rebuild)}};
}

/// The part of mj_forward that computes unconstrained accelerations: positions, inertias, bias, and a solution with the
/// factorised mass matrix.
struct Forward : Evaluator {
  explicit Forward(const EvaluationModel& m) : model(m.links, -1, ""), first(m.floating() ? 1 : 0), bias(model.model->nv) {
    model.model->opt.gravity[2] = gravity;
    for (const Link& link : m.links) {
      place.push_back(static_cast<int>(model.q(link) - model.data->qpos));
      row.push_back(static_cast<int>(model.v(link) - model.data->qvel));
    }
    const Link& root = m.links.front();
    turn = root.turn;
    if (root.free) Engine::put(model, root, {root.turn, root.at, root.linear, root.angular});
  }
  void evaluate(const double* q, const double* u) override {
    const mjModel* m = model.model;
    mjData* d = model.data;
    for (std::size_t i = first; i < row.size(); ++i) d->qpos[place[i]] = q[i], d->qvel[row[i]] = u[i];
    mj_kinematics(m, d);
    mj_comPos(m, d);
    mj_crb(m, d);
    mj_factorM(m, d);
    mj_comVel(m, d);
    mj_rne(m, d, 0, bias.data());
    for (double& force : bias) force = -force;
    mj_solveM(m, d, d->qacc, bias.data(), 1);
  }
  std::vector<double> accelerations() override {
    std::vector<double> a;
    for (const int r : row) a.push_back(model.data->qacc[r]);
    if (first == 0) return a;
    a[0] = 0;
    const double* found = model.data->qacc;  // in world axes, then in body axes
    const Vector3d angular = turn * Vector3d(found[3], found[4], found[5]);
    a.insert(a.end(), found, found + 3);
    a.insert(a.end(), angular.data(), angular.data() + 3);
    return a;
  }
  Model model;
  std::size_t first;  // the first revolute joint
  Matrix3d turn;
  std::vector<int> place, row;
  std::vector<double> bias;
};

}  // namespace

int main(int count, char** words) {
  const std::string name = std::string("MuJoCo ") + mj_versionString();
  if (count == 1) return run(name, ways);
  return evaluate(name, {{"mj_kinematics … mj_solveM", evaluator<Forward>()}}, {words + 2, words + count});
}
