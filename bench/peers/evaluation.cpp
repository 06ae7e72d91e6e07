#include "evaluation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace peers {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// Forces at the joints by Newton–Euler; `largest`: the largest single term among them.
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
    b.arm = outer.R * (link.slides ? Vector3d(link.at + q[i] * link.turn.col(2)) : link.at);
    if (link.free) {
      const double* found = udot.data() + bodies.size();
      b.R = link.turn;
      b.w = link.angular;
      b.a = Vector3d(found[0], found[1], found[2]) + outer.a;
      b.alpha = {found[3], found[4], found[5]};
    } else {
      b.R = outer.R * link.turn;
      if (!link.slides) b.R *= Eigen::AngleAxisd(q[i], Vector3d::UnitZ()).toRotationMatrix();
      b.axis = b.R.col(2);
      const Vector3d slip = link.slides ? b.axis : Vector3d::Zero(), spin = b.axis - slip;
      b.w = outer.w + u[i] * spin;
      b.alpha = outer.alpha + udot[i] * spin + u[i] * outer.w.cross(spin);
      b.a = outer.a + outer.alpha.cross(b.arm) + outer.w.cross(outer.w.cross(b.arm)) + udot[i] * slip +
            2 * u[i] * outer.w.cross(slip);
    }
    const Vector3d c = b.R * link.com;
    const Matrix3d principal = b.R * link.axes;
    const auto inertia = [&](const Vector3d& x) -> Vector3d {
      return principal * link.inertia.cwiseProduct(principal.transpose() * x);
    };
    b.f = link.mass * (b.a + b.alpha.cross(c) + b.w.cross(b.w.cross(c)));
    b.n = inertia(b.alpha) + b.w.cross(inertia(b.w)) + c.cross(b.f);
    largest = std::max({largest, inertia(b.alpha).norm(), c.norm() * link.mass * b.a.norm()});
  }
  std::vector<double> force(bodies.size());
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& b = bodies[i];
    force[i] = model.links[i].free     ? std::max(b.f.norm() * b.arm.norm(), b.n.norm())
               : model.links[i].slides ? b.axis.dot(b.f)
                                       : b.axis.dot(b.n);
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

bool is_chain(const EvaluationModel& model) {
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (model.links[i].free || model.links[i].parent + 1 != static_cast<int>(i)) return false;
  return true;
}

Turns turns_of(const EvaluationModel& model) {
  Turns turns;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const Link& link = model.links[i];
    turns.q[0].push_back(link.angle), turns.u[0].push_back(link.rate);
    turns.q[1].push_back(link.angle + 1e-3 * static_cast<double>(i % 7 + 1)), turns.u[1].push_back(link.rate + 1e-3);
  }
  return turns;
}

int evaluate(const std::string& engine, const std::vector<Evaluation>& ways, const std::vector<std::string>& files) {
  int wrong = 0;
  for (const EvaluationModel& model : models(files)) {
    const std::size_t n = model.links.size();
    const auto [q, u] = turns_of(model);
    for (const Evaluation& way : ways) {
      if (static_cast<int>(n) > way.most || (way.chains_only && !is_chain(model))) continue;
      const std::unique_ptr<Evaluator> engine_with_model = way.make(model);
      double error = 0;
      for (const int k : {0, 1, 0}) {
        engine_with_model->evaluate(q[k].data(), u[k].data());
        const double e = imbalance(model, q[k], u[k], engine_with_model->accelerations());
        if (!(e <= error)) error = e;
      }
      if (!(error < allowed_imbalance(model))) {
        std::fprintf(stderr, "%s, %s, %s: the accelerations are wrong, joints are off balance by %g\n", engine.c_str(),
                     way.name.c_str(), model.name.c_str(), error);
        wrong = 1;
        continue;
      }
      double best = HUGE_VAL;
      int turn = 0;
      const Clock::time_point begin = Clock::now();
      for (int repeat = 0; repeat < 20 || since(begin) < 1; ++repeat) {
        const int count = batch(model);
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
