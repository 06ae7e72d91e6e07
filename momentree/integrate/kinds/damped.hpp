#pragma once
// For joints so strongly damped that an explicit method would have to follow how fast they come to rest: dampers are taken
// implicitly, everything else explicitly. The implicit-explicit Runge–Kutta method (4,4,3) of Ascher, Ruuth and Spiteri (1997):
// order 3, fixed steps, four evaluations each; its implicit part is L-stable, and the new state is its last stage.
//
// A stage finds velocities u by (H + γ h C) u = p*, where p* is all that is known of its momenta, and p = p* − γ h C u. H + γ h C
// is the mass with larger rotors: γ h C stands beside the armature in the first recursion, so that a stage costs an evaluation.
// The rest of that evaluation is right as well: a rotor is no part of Pb, and the rates (20) are those of the velocities u.
#include <cmath>
#include <optional>

#include <momentree/integrate/integrator.hpp>

namespace momentree {

class Damped final : public Integrator {
 public:
  static constexpr bool chooses_steps = false;
  Damped(const Tree& tree, const StepControl& control);
  bool step(Evaluator& evaluate, State& state, Books& books, double h) noexcept override;

 private:
  static constexpr int stages = 5;
  static constexpr double gamma = 0.5;
  static constexpr double c[stages] = {0, 1.0 / 2, 2.0 / 3, 1.0 / 2, 1};
  static constexpr double explicit_part[stages][stages] = {
      {}, {1.0 / 2}, {11.0 / 18, 1.0 / 18}, {5.0 / 6, -5.0 / 6, 1.0 / 2}, {1.0 / 4, 7.0 / 4, 3.0 / 4, -7.0 / 4}};
  static constexpr double implicit_part[stages][stages] = {
      {}, {0, gamma}, {0, 1.0 / 6, gamma}, {0, -1.0 / 2, 1.0 / 2, gamma}, {0, 3.0 / 2, -3.0 / 2, 1.0 / 2, gamma}};

  double* qdot(int stage) const { return qdot_.get() + stage * nq_max_; }
  double* pdot(int stage) const { return pdot_.get() + stage * nv_max_; }
  double* velocity(int stage) const { return velocity_.get() + stage * nv_max_; }
  void follow(const Tree& tree);
  double taken(int nv, double h, const double* u_after) const noexcept;

  long nq_max_, nv_max_;
  std::unique_ptr<double[]> q_, p_;                   // stage, then result
  std::unique_ptr<double[]> qdot_, pdot_, velocity_;  // of the stages; ṗ without dampers
  std::unique_ptr<double[]> damping_;
  Tree massive_;  // the same tree, whose rotors carry γ h C
  std::optional<std::uint64_t> revision_;
};

inline Damped::Damped(const Tree& tree, const StepControl& control)
    : Integrator(control),
      nq_max_(7L * tree.bodies()),
      nv_max_(6L * tree.bodies()),
      q_(scratch(nq_max_)),
      p_(scratch(nv_max_)),
      qdot_(scratch(stages * nq_max_)),
      pdot_(scratch(stages * nv_max_)),
      velocity_(scratch(stages * nv_max_)),
      damping_(scratch(nv_max_)) {
  follow(tree);
}

inline void Damped::follow(const Tree& tree) {
  massive_.copy_with_rotors(tree);
  revision_ = tree.revision();
}

inline bool Damped::step(Evaluator& evaluate, State& state, Books& books, double h) noexcept {
  const Tree& tree = evaluate.tree();
  const Work<double>& work = evaluate.work();
  MT_REQUIRE(work.evaluated == state.stamp(), "the first stage was evaluated on this state");
  if (revision_ != tree.revision()) follow(tree);
  const int nq = tree.nq(), nv = tree.nv();
  const double *q = state.q().data(), *p = state.p().data(), *armature = tree.armature();
  double *damping = damping_.get(), *rotors = massive_.rotors();
  joint_damping(tree, q, work.v.get(), damping);
  for (int i = 0; i < nv; ++i) rotors[i] = armature[i] + gamma * h * damping[i];

  double done = 0, lost = 0;  // work, and what others than dampers dissipate
  for (int s = 0; s < stages; ++s) {
    if (s > 0) {
      std::copy_n(q, nq, q_.get());
      std::copy_n(p, nv, p_.get());
      for (int j = 0; j < s; ++j) {
        const double e = h * explicit_part[s][j], im = h * implicit_part[s][j];
        const double *rate = qdot(j), *force = pdot(j), *u = velocity(j);
        for (int i = 0; i < nq; ++i) q_[static_cast<std::size_t>(i)] += e * rate[i];
        for (int i = 0; i < nv; ++i) p_[static_cast<std::size_t>(i)] += e * force[i] - im * damping[i] * u[i];
      }
      evaluate.without_dampers(massive_, state.time() + c[s] * h, q_.get(), p_.get());
    }
    std::copy_n(work.qdot.get(), nq, qdot(s));
    std::copy_n(work.v.get(), nv, velocity(s));
    // The first stage is the state's own evaluation, with dampers.
    for (int i = 0; i < nv; ++i)
      pdot(s)[i] = work.pdot[static_cast<std::size_t>(i)] + (s == 0 ? damping[i] * work.v[static_cast<std::size_t>(i)] : 0.0);
    if (s + 1 == stages) continue;
    const double share = h * explicit_part[stages - 1][s];
    lost += share * work.power.dissipated;
    for (int i = 0; i < nv && s == 0; ++i) lost -= share * damping[i] * velocity(0)[i] * velocity(0)[i];  // see `taken`
    if (s > 0 && !tree.driven_joints().empty()) {  // what a prescribed motion takes depends on accelerations by the true mass
      for (int i = 0; i < nv; ++i) p_[static_cast<std::size_t>(i)] -= gamma * h * damping[i] * velocity(s)[i];
      evaluate(state.time() + c[s] * h, q_.get(), p_.get());
    }
    done += share * work.power.work;
  }
  const double* u = velocity(stages - 1);
  for (int i = 0; i < nv; ++i) p_[static_cast<std::size_t>(i)] -= gamma * h * damping[i] * u[i];
  end_step(tree, state.time() + h, q_.get(), p_.get());
  if (!plausible(tree, q, q_.get(), p_.get())) return false;
  take_stored(tree, q, q_.get(), books);
  const State::Edit edit = state.edit();
  std::copy_n(q_.get(), nq, edit.q.begin());
  std::copy_n(p_.get(), nv, edit.p.begin());
  edit.time += h;
  books.dissipated += taken(nv, h, u) + lost;
  books.work += done;
  return true;
}

// What the dampers took: ∫ c u² dt. Of u are known its ends and, from the impulse I of the damper, its mean I/(h c). Where it
// changes by less than that, the parabola through them is integrated. Where a joint comes to rest within the step it is I that
// tells: ∫ u dI, u falling in proportion.
inline double Damped::taken(int nv, double h, const double* u_after) const noexcept {
  double sum = 0;
  for (int i = 0; i < nv; ++i) {
    const double damping = damping_[static_cast<std::size_t>(i)];
    if (damping == 0) continue;
    double mean = 0;
    for (int j = 0; j < stages; ++j) mean += implicit_part[stages - 1][j] * velocity(j)[i];
    const double before = velocity(0)[i], after = u_after[i], change = after - before, bend = 0.5 * (before + after) - mean;
    const double square = std::fabs(change) <= std::fabs(mean) ? mean * mean + change * change / 12 + bend * bend / 5
                                                               : 0.5 * (before + after) * mean;
    sum += h * damping * square;
  }
  return sum;
}

}  // namespace momentree
