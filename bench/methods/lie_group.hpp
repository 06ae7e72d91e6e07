#pragma once
// An experiment: the classical tableau on the Lie group (Munthe-Kaas 1998). Quaternions are advanced as Q exp(θ), θ̇ =
// dexpinv(ω); everything else as in rk4.
#include <momentree/integrate/integrator.hpp>

namespace momentree::bench {

class Rkmk4 {
 public:
  explicit Rkmk4(const Tree& tree) {
    for (const int b : tree.joints_with().quaternions) {
      const bool free = tree.joint(b).kind == Kind::free;
      turns_.push_back({tree.first_q(b) + (free ? 3 : 0), tree.first_p(b) + (free ? 3 : 0), {}, {}});
    }
    q_.resize(static_cast<std::size_t>(tree.nq())), q_sum_ = q_;
    p_.resize(static_cast<std::size_t>(tree.nv())), p_sum_ = p_;
  }

  /// One step; the workspace is evaluated at the state.
  void step(Evaluator& evaluate, State& state, double h) {
    const Workspace<double>& workspace = evaluate.workspace();
    constexpr double weights[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}, nodes[4] = {0.5, 0.5, 1, 0};
    std::fill(q_sum_.begin(), q_sum_.end(), 0), std::fill(p_sum_.begin(), p_sum_.end(), 0);
    for (Turn& turn : turns_) turn.stage = turn.sum = {};
    for (int s = 0; s < 4; ++s) {
      if (s > 0) evaluate(state.time() + nodes[s - 1] * h, q_.data(), p_.data());
      for (std::size_t i = 0; i < q_.size(); ++i) {
        q_sum_[i] += h * weights[s] * workspace.qdot[i];
        q_[i] = state.q()[i] + h * nodes[s] * workspace.qdot[i];
      }
      for (std::size_t i = 0; i < p_.size(); ++i) {
        p_sum_[i] += h * weights[s] * workspace.pdot[i];
        p_[i] = state.p()[i] + h * nodes[s] * workspace.pdot[i];
      }
      for (Turn& turn : turns_) {
        const double* w = workspace.v.get() + turn.at_p;
        const Vec3 omega{w[0], w[1], w[2]}, once = cross(turn.stage, omega);
        const Vec3 rate = omega + 0.5 * once + (1.0 / 12) * cross(turn.stage, once);
        turn.sum += h * weights[s] * rate;
        turn.stage = h * nodes[s] * rate;
        turned(state, turn, turn.stage, q_.data());
      }
    }
    for (std::size_t i = 0; i < q_.size(); ++i) q_[i] = state.q()[i] + q_sum_[i];
    for (std::size_t i = 0; i < p_.size(); ++i) p_[i] = state.p()[i] + p_sum_[i];
    for (Turn& turn : turns_) turned(state, turn, turn.sum, q_.data());
    const State::Edit edit = state.edit();
    std::copy(q_.begin(), q_.end(), edit.q.begin());
    std::copy(p_.begin(), p_.end(), edit.p.begin());
    edit.time += h;
  }

 private:
  struct Turn {
    int at_q, at_p;
    Vec3 stage{}, sum{};
  };
  static void turned(const State& state, const Turn& turn, const Vec3& by, double* out) {
    const double* start = state.q().data() + turn.at_q;
    const double angle = norm(by), part = angle > 1e-8 ? std::sin(angle / 2) / angle : 0.5;
    const Quat q = normalized(Quat{start[0], start[1], start[2], start[3]} *
                              Quat{std::cos(angle / 2), part * by.x, part * by.y, part * by.z});
    double* to = out + turn.at_q;
    to[0] = q.w, to[1] = q.x, to[2] = q.y, to[3] = q.z;
  }

  std::vector<Turn> turns_;
  std::vector<double> q_, p_, q_sum_, p_sum_;
};

}  // namespace momentree::bench
