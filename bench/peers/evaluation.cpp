#include "evaluation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>

namespace peers {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * (static_cast<double>(engine_()) / 4294967295.0); }
  Vector3d within(double size) {
    const double x = between(-size, size), y = between(-size, size), z = between(-size, size);
    return {x, y, z};
  }

 private:
  std::mt19937 engine_;
};

Link pin(Draw& draw, int number, int parent, bool planar) {
  Link link;
  link.name = "b" + std::to_string(number);
  link.parent = parent;
  link.mass = draw.between(0.5, 1.5);
  link.at = parent < 0 ? Vector3d::Zero() : Vector3d(0.2, 0, 0);
  if (planar) {
    link.com = {0.1, 0, 0};
    if (parent < 0) link.turn = Eigen::AngleAxisd(1.5707963267948966, Vector3d::UnitX()).toRotationMatrix();  // upright
  } else {
    const Vector3d by = draw.within(1.2);
    link.turn = Eigen::AngleAxisd(by.norm(), by.normalized()).toRotationMatrix();
    link.com = Vector3d(0.1, 0, 0) + draw.within(0.03);
  }
  link.inertia = link.mass * 0.04 * Vector3d(0.2, 0.7, 0.8);
  link.angle = draw.between(-0.6, 0.6);
  link.rate = draw.between(-1, 1);
  return link;
}

EvaluationModel tree(const char* name, int bodies, bool planar, bool binary) {
  Draw draw(static_cast<unsigned>(bodies));
  EvaluationModel model{std::string(name) + " " + std::to_string(bodies), {}};
  for (int i = 0; i < bodies; ++i) model.links.push_back(pin(draw, i, binary ? (i + 1) / 2 - 1 : i - 1, planar));
  return model;
}

/// A free pelvis and 30 pins along the axes of a body that stands: two legs of 6, waist and neck of 2, two arms of 7.
class Humanoid {
 public:
  EvaluationModel model() {
    const double side = 0.1, leg = 0.4, arm = 0.27;
    const int pelvis = add(-1, 'z', Vector3d::Zero());
    for (const double s : {side, -side}) limb(pelvis, "zxyyyx", {{0, s, -0.05}, {}, {}, {0, 0, -leg}, {0, 0, -leg}, {}});
    const int chest = limb(pelvis, "zy", {{0, 0, 0.1}, {}});
    for (const double s : {2 * side, -2 * side})
      limb(chest, "yxzyzyx", {{0, s, 0.3}, {}, {}, {0, 0, -arm}, {}, {0, 0, -arm}, {}});
    limb(chest, "zy", {{0, 0, 0.4}, {}});
    return {"humanoid " + std::to_string(links_.size() - 1) + "+6", links_};
  }

 private:
  struct Offset {
    double x = 0, y = 0, z = 0;
  };
  int limb(int last, const char* axes, std::initializer_list<Offset> offsets) {
    for (const Offset& offset : offsets) last = add(last, *axes++, {offset.x, offset.y, offset.z});
    return last;
  }
  /// Axis and offset from the parent's origin as seen by the world where all angles are zero.
  int add(int parent, char axis, const Vector3d& offset) {
    const int number = static_cast<int>(links_.size());
    Link link = pin(draw_, number, parent, false);
    const double right = 1.5707963267948966;
    Matrix3d stands = Matrix3d::Identity();
    if (axis == 'x') stands = Eigen::AngleAxisd(right, Vector3d::UnitY()).toRotationMatrix();
    if (axis == 'y') stands = Eigen::AngleAxisd(-right, Vector3d::UnitX()).toRotationMatrix();
    const Matrix3d parent_stands = parent < 0 ? Matrix3d::Identity() : stands_[parent];
    link.turn = parent_stands.transpose() * stands;
    for (double& x : link.turn.reshaped()) x = std::round(x);  // quarter turns
    link.at = parent_stands.transpose() * offset;
    if (parent < 0) {
      link.free = true;
      link.turn = Eigen::AngleAxisd(0.7, Vector3d(0.6, 0, 0.8)).toRotationMatrix();
      link.at = {0.1, 0.2, 1};
      link.linear = {0.1, -0.2, 0.3}, link.angular = {0.4, -0.5, 0.6};
    }
    links_.push_back(link);
    stands_.push_back(stands);
    return number;
  }
  Draw draw_{31};
  std::vector<Link> links_;
  std::vector<Matrix3d> stands_;
};

std::vector<EvaluationModel> models() {
  return {tree("planar chain", 1, true, false),     tree("planar chain", 10, true, false),
          tree("planar chain", 100, true, false),   tree("planar chain", 1000, true, false),
          tree("spatial chain", 1, false, false),   tree("spatial chain", 7, false, false),
          tree("spatial chain", 100, false, false), tree("spatial chain", 1000, false, false),
          tree("binary tree", 63, false, true),     Humanoid().model()};
}

/// Forces at the joints by Newton and Euler; `largest`: the largest single term among them.
std::vector<double> joint_forces(const EvaluationModel& model, const std::vector<double>& q, const std::vector<double>& u,
                                 const std::vector<double>& udot, double& largest) {
  struct Body {
    Matrix3d R;
    Vector3d arm, axis, w, alpha, a, f, n;
  };
  std::vector<Body> bodies(model.links.size());
  largest = 0;
  const Body ground{Matrix3d::Identity(), Vector3d::Zero(),         Vector3d::Zero(), Vector3d::Zero(),
                    Vector3d::Zero(),     Vector3d(0, 0, -gravity), Vector3d::Zero(), Vector3d::Zero()};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Link& link = model.links[i];
    const Body& outer = link.parent < 0 ? ground : bodies[link.parent];
    Body& b = bodies[i];
    b.arm = outer.R * link.at;
    if (link.free) {
      const double* found = udot.data() + bodies.size();
      b.R = link.turn;
      b.w = link.angular;
      b.a = Vector3d(found[0], found[1], found[2]) + outer.a;
      b.alpha = {found[3], found[4], found[5]};
    } else {
      b.R = outer.R * link.turn * Eigen::AngleAxisd(q[i], Vector3d::UnitZ()).toRotationMatrix();
      b.axis = b.R.col(2);
      b.w = outer.w + u[i] * b.axis;
      b.alpha = outer.alpha + udot[i] * b.axis + u[i] * outer.w.cross(b.axis);
      b.a = outer.a + outer.alpha.cross(b.arm) + outer.w.cross(outer.w.cross(b.arm));
    }
    const Vector3d c = b.R * link.com;
    const auto inertia = [&](const Vector3d& x) -> Vector3d { return b.R * link.inertia.cwiseProduct(b.R.transpose() * x); };
    b.f = link.mass * (b.a + b.alpha.cross(c) + b.w.cross(b.w.cross(c)));
    b.n = inertia(b.alpha) + b.w.cross(inertia(b.w)) + c.cross(b.f);
    largest = std::max({largest, inertia(b.alpha).norm(), c.norm() * link.mass * b.a.norm()});
  }
  std::vector<double> force(bodies.size());
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& b = bodies[i];
    force[i] = model.links[i].free ? std::max(b.f.norm() * b.arm.norm(), b.n.norm()) : b.axis.dot(b.n);
    largest = std::max({largest, b.n.norm(), b.arm.norm() * b.f.norm()});
    const int parent = model.links[i].parent;
    if (parent < 0) continue;
    bodies[parent].f += b.f;
    bodies[parent].n += b.n + b.arm.cross(b.f);
  }
  return force;
}

}  // namespace

double imbalance(const EvaluationModel& model, const std::vector<double>& q, const std::vector<double>& u,
                 const std::vector<double>& a) {
  double largest = 0, missing = 0;
  for (const double force : joint_forces(model, q, u, a, largest)) {
    if (!(std::abs(force) <= missing)) missing = std::abs(force);
  }
  return missing / largest;
}

namespace {

bool is_chain(const EvaluationModel& model) {
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (model.links[i].free || model.links[i].parent + 1 != static_cast<int>(i)) return false;
  return true;
}

}  // namespace

int evaluate(const std::string& engine, const std::vector<Evaluation>& ways) {
  int wrong = 0;
  for (const EvaluationModel& model : models()) {
    const std::size_t n = model.links.size();
    std::vector<double> q[2], u[2];
    for (std::size_t i = 0; i < n; ++i) {
      q[0].push_back(model.links[i].angle), u[0].push_back(model.links[i].rate);
      q[1].push_back(q[0][i] + 1e-3 * static_cast<double>(i % 7 + 1)), u[1].push_back(u[0][i] + 1e-3);
    }
    for (const Evaluation& way : ways) {
      if (static_cast<int>(n) > way.most || (way.chains_only && !is_chain(model))) continue;
      const std::unique_ptr<Evaluator> engine_with_model = way.make(model);
      double error = 0;
      for (const int k : {0, 1, 0}) {
        engine_with_model->evaluate(q[k].data(), u[k].data());
        const double e = imbalance(model, q[k], u[k], engine_with_model->accelerations());
        if (!(e <= error)) error = e;
      }
      // What momenta are worth in velocities grows with a power of the chain's length (README.md); a mistake is of the order
      // of 1.
      if (!(error < (n <= 100 ? 1e-8 : 1e-4))) {
        std::fprintf(stderr, "%s, %s, %s: the accelerations are wrong, joints are off balance by %g\n", engine.c_str(),
                     way.name.c_str(), model.name.c_str(), error);
        wrong = 1;
        continue;
      }
      double best = HUGE_VAL;
      int turn = 0;
      const Clock::time_point begin = Clock::now();
      for (int repeat = 0; repeat < 20 || since(begin) < 1; ++repeat) {
        const int count = static_cast<int>(1 + 1000 / n);
        const Clock::time_point at = Clock::now();
        for (int i = 0; i < count; ++i) turn ^= 1, engine_with_model->evaluate(q[turn].data(), u[turn].data());
        best = std::min(best, since(at) / count);
      }
      std::printf("{\"model\": \"%s\", \"engine\": \"%s\", \"way\": \"%s\", \"imbalance\": %.2g, \"ns_per_body\": %.4g}\n",
                  model.name.c_str(), engine.c_str(), way.name.c_str(), error, best * 1e9 / static_cast<double>(n));
      std::fflush(stdout);
    }
  }
  return wrong;
}

}  // namespace peers
