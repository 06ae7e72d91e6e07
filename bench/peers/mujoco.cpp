// MuJoCo. Joints that are made or broken at run time are equality constraints, declared in advance and switched by eq_active.
// They are soft by design. With the default solref (0.02 s, critically damped) an activated constraint needs time to act: its
// result is evaluated 0.3 s later (without gravity and damping, energy and momenta are conserved until then), integrated by RK4
// as recommended if energy matters. The integrator `discrete` admits constraints that are as hard as solimp allows, which act
// within a step. Changes that were not foreseen edit the model (mjSpec) and recompile it, which keeps the state of the joints
// that remain.
#include <algorithm>

#include "evaluation.hpp"
#include "measure.hpp"
#include "mujoco_model.hpp"

namespace {

using namespace peers;

enum class How { edit, rebuild, connects, soft, hard };
constexpr double settling = 0.3;

struct Engine : Trial {
  Engine(const Experiment& experiment, How way, double h) : e(experiment), how(way), step(h), links(e.links) {
    if (how == How::connects) loosen(start(e)[e.body]);
    make(-1);
    for (const Link& each : links) {
      if (each.free) now->set(each, {each.turn, each.at, each.linear, each.angular});
      if (!each.free) *now->q(each) = each.angle, *now->v(each) = each.rate;
    }
    mj_forward(now->model, now->data);
  }

  void make(int fixed) {
    now = std::make_unique<Model>(links, fixed);
    if (how == How::connects) {  // the revolute joint that will break: two points on the axis of a loose body are constrained
      for (const double z : {0.0, 0.1}) declare(mjEQ_CONNECT, e.links[e.body].parent)->data[2] = z;
    }
    if (how == How::soft || how == How::hard) {
      if (e.change == Change::lock) declare(mjEQ_JOINT, -1)->active = false;
      if (e.change == Change::capture) declare(mjEQ_WELD, e.to)->active = false;
    }
    if (how == How::hard) {
      now->spec->option.integrator = mjINT_DISCRETE;
      now->spec->option.timestep = step;
    }
    now->compile();
  }
  /// An equality between the body and another one, or of its joint.
  mjsEquality* declare(mjtEq type, int other) {
    mjsEquality* made = mjs_addEquality(now->spec, nullptr);
    made->type = type;
    made->objtype = type == mjEQ_JOINT ? mjOBJ_JOINT : mjOBJ_BODY;
    if (type != mjEQ_JOINT) std::fill(made->data, made->data + 3, 0);  // the anchor; by default these are a polynomial's
    // The data of a connect are in the first body, those of a weld in the second.
    if (type == mjEQ_WELD) std::swap(made->name1, made->name2);
    mjs_setString(made->name1, links[e.body].name.c_str());
    if (other >= 0) mjs_setString(made->name2, links[other].name.c_str());
    if (type == mjEQ_WELD) std::swap(made->name1, made->name2);
    if (how == How::hard) {
      made->solref[0] = 1e-3 * step;
      std::fill(made->solimp, made->solimp + 2, 0.9999);  // the largest that has an effect
    }
    return made;
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
    if (how == How::edit) return edit();
    if (how == How::connects) data->eq_active[0] = data->eq_active[1] = 0;
    if (how == How::soft || how == How::hard) {
      if (e.change == Change::lock) model->eq_data[0] = *now->q(links[e.body]);  // the constant of the polynomial
      if (e.change == Change::capture) {
        const Pose held = held_in_hand();
        model->eq_data[10] = 1;  // weight of the torques; the anchor, in the second body, stays at its origin
        put(held.p, model->eq_data + 3), put(held.R, model->eq_data + 6);
      }
      data->eq_active[0] = 1;
    }
    if (how == How::hard) mj_step(model, data), time = data->time;
    mj_forward(model, data);
  }
  void settle() override {
    if (how != How::soft) return;
    while (now->data->time < settling) mj_step(now->model, now->data);
    time = now->data->time;
    mj_forward(now->model, now->data);
  }
  double elapsed() const override { return time; }

  struct Pose {
    Matrix3d R;
    Vector3d p;
  };
  Pose held_in_hand() const {
    const Motion hand = now->read(links[e.to]), held = now->read(links[e.body]);
    return {hand.R.transpose() * held.R, hand.R.transpose() * (held.p - hand.p)};
  }

  /// Copies the state of a joint from another model with the same joints.
  static void copy(const Link& link, const Model& from, const Model& to) {
    mju_copy(to.q(link), from.q(link), link.free ? 7 : 1);
    mju_copy(to.v(link), from.v(link), link.free ? 6 : 1);
  }

  /// Another model, whose joints get the state of the joints with the same names.
  void rebuild() {
    Link& link = links[e.body];
    int fixed = -1;
    if (e.change == Change::cut) loosen(now->read(link));
    if (e.change == Change::capture) {
      const Pose held = held_in_hand();
      link.parent = e.to, link.free = false, fixed = e.body;
      link.turn = held.R, link.at = held.p;
    }
    const std::unique_ptr<Model> old = std::move(now);
    make(fixed);
    for (int i = 0; i < static_cast<int>(links.size()); ++i) {
      if (i != e.body) copy(links[i], *old, *now);
    }
    if (e.change == Change::cut) now->set(link, {link.turn, link.at, link.linear, link.angular});
    mj_forward(now->model, now->data);
  }

  /// Edits the specification and recompiles it. There is no function that moves a body to another parent: a copy of it is
  /// attached there, without the states of its joints, and the body is deleted.
  void edit() {
    Link& link = links[e.body];
    mjsBody* body = now->body_spec(link);
    if (e.change == Change::lock) {  // without the joint: the angle becomes part of the body's pose
      put(Matrix3d(link.turn * Eigen::AngleAxisd(*now->q(link), Vector3d::UnitZ()).toRotationMatrix()), body->quat);
      mjs_delete(now->spec, mjs_findElement(now->spec, mjOBJ_JOINT, link.name.c_str()));
      now->recompile();
      mj_forward(now->model, now->data);
      return;
    }
    const Motion motion = now->read(link);
    const std::vector<int> moved = subtree(e.links, e.body);
    std::vector<double> q, v;
    for (const int i : moved) q.push_back(*now->q(links[i])), v.push_back(*now->v(links[i]));
    const bool cut = e.change == Change::cut;
    const Pose pose = cut ? Pose{motion.R, motion.p} : held_in_hand();
    mjs_setDeepCopy(now->spec, 1);
    mjsFrame* frame = mjs_addFrame(cut ? mjs_findBody(now->spec, "world") : now->body_spec(links[e.to]), nullptr);
    mjsBody* made = mjs_asBody(mjs_attach(frame->element, body->element, "moved ", ""));
    mjs_delete(now->spec, body->element);
    for (const int i : moved) links[i].name = "moved " + links[i].name;
    put(pose.p, made->pos), put(pose.R, made->quat);
    mjs_delete(now->spec, mjs_findElement(now->spec, mjOBJ_JOINT, link.name.c_str()));
    if (cut) mjs_setName(mjs_addFreeJoint(made)->element, link.name.c_str());
    now->recompile();
    for (std::size_t i = 1; i < moved.size(); ++i) *now->q(links[moved[i]]) = q[i], *now->v(links[moved[i]]) = v[i];
    if (cut) now->set(link, motion);
    mj_forward(now->model, now->data);
  }

  std::vector<Motion> motions() override {
    std::vector<Motion> all;
    for (const Link& link : links) all.push_back(now->read(link));
    return all;
  }

  Experiment e;
  How how;
  double step;
  std::vector<Link> links;
  std::unique_ptr<Model> now;
  double time = 0;
};

std::vector<Way> ways(Change change) {
  const std::string soft = "foreseen: declared beforehand; soft, judged 0.3 s later, time is of the switching";
  const std::string hard = "foreseen: declared beforehand; as hard as it can be";
  if (change == Change::cut) {
    return {
        {"attach a copy, delete, recompile", "needs a recompilation", maker<Engine>(How::edit, 0.0)},
        {"rebuild, copy the state", "needs a rebuild", maker<Engine>(How::rebuild, 0.0)},
        {"two connects, eq_active = 0", "foreseen: the pin is soft constraints until then", maker<Engine>(How::connects, 0.0)}};
  }
  const std::string name = change == Change::lock ? "joint" : "weld";
  std::vector<Way> found{{name + " equality, eq_active = 1", soft, maker<Engine>(How::soft, 0.0)},
                         {name + " equality, discrete, step of 1 µs", hard, maker<Engine>(How::hard, 1e-6)},
                         {name + " equality, discrete, step of 1 ms", hard, maker<Engine>(How::hard, 1e-3)}};
  if (change == Change::lock) {
    found.push_back(
        {"delete the joint, recompile", "needs a recompilation; zeroes the joint's speed", maker<Engine>(How::edit, 0.0)});
  } else {
    found.push_back({"attach a copy to the hand, delete, recompile", "needs a recompilation; takes on the hand's velocity",
                     maker<Engine>(How::edit, 0.0)});
  }
  return found;
}

/// The part of mj_forward that computes unconstrained accelerations: positions, inertias, bias, and a solution with the
/// factorised mass matrix.
struct Forward : Evaluator {
  explicit Forward(const EvaluationModel& m) : model(m.links), first(m.floating() ? 1 : 0) {
    model.spec->option.gravity[2] = gravity;
    model.compile();
    bias.resize(static_cast<std::size_t>(model.model->nv));
    for (const Link& link : m.links) {
      place.push_back(static_cast<int>(model.q(link) - model.data->qpos));
      row.push_back(static_cast<int>(model.v(link) - model.data->qvel));
    }
    const Link& root = m.links.front();
    turn = root.turn;
    if (root.free) model.set(root, {root.turn, root.at, root.linear, root.angular});
  }
  void evaluate(const double* q, const double* u) override {
    const mjModel* m = model.model;
    mjData* d = model.data;
    for (std::size_t i = first; i < row.size(); ++i) d->qpos[place[i]] = q[i], d->qvel[row[i]] = u[i];
    mj_kinematics(m, d);
    mj_comPos(m, d);
    mj_makeM(m, d);
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
