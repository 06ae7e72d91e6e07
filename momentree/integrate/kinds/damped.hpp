#pragma once
// For joints so strongly damped that an explicit method would have to resolve their fast decay: dampers, friction, soft stops and
// position control are integrated implicitly, everything else explicitly. The implicit-explicit Runge–Kutta method (4,4,3) of
// Ascher, Ruuth and Spiteri (1997): order 3, fixed steps, four evaluations each; its implicit part is L-stable, and the new state
// is its last stage.
//
// A stage solves (H + γ h C) u = p* for the velocities u, with p* the known part of its momenta, and p = p* − γ h C u. H + γ h C
// is the mass matrix with larger armatures: γ h C is added to the armature in the first recursion, so that a stage costs one
// evaluation. The rest of that evaluation is correct as well: the armature is not part of Pb, and the rates (20) are those of the
// velocities u. Forces that are not linear in u are linearised, f(w) − C (u − w), and −C u is the part treated as armature.
//
// The forces of joints that close loops and of springs between points are in the explicit part. Loops add their impulses to p*
// in every stage, with the rows of H + γ h C: see loop_momenta.hpp.
#include <cmath>
#include <optional>

#include <momentree/dynamics/forces/resistance.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

class Damped final : public Integrator {
 public:
  static constexpr bool chooses_steps = false, takes_velocities = false, supports_contact = false, steps_through_contacts = false;
  static constexpr Variables default_variables = Variables::momenta;
  static constexpr const char* other_name = "imex";
  // Dampers at any step; springs as in its explicit part.
  static constexpr double damper_limit = HUGE_VAL, spring_limit = 1.57;
  static constexpr double explicit_damper_limit = 2.14;  ///< of dampers of loop joints and of springs between points
  static constexpr double implicit_share = 0.5;          ///< γ
  Damped(const Tree& tree, const StepControl& control);
  bool step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept override;

 private:
  static constexpr int stages = 5;
  static constexpr double gamma = implicit_share;
  static constexpr int most_linearised = 20;  // per stage; one to three are usual
  static constexpr double c[stages] = {0, 1.0 / 2, 2.0 / 3, 1.0 / 2, 1};
  static constexpr double explicit_part[stages][stages] = {
      {}, {1.0 / 2}, {11.0 / 18, 1.0 / 18}, {5.0 / 6, -5.0 / 6, 1.0 / 2}, {1.0 / 4, 7.0 / 4, 3.0 / 4, -7.0 / 4}};
  static constexpr double implicit_part[stages][stages] = {
      {}, {0, gamma}, {0, 1.0 / 6, gamma}, {0, -1.0 / 2, 1.0 / 2, gamma}, {0, 3.0 / 2, -3.0 / 2, 1.0 / 2, gamma}};

  using Array = std::unique_ptr<double[]>;
  double* rate(const Array& of, int stage) const { return of.get() + stage * nv_max_; }
  void follow(const Tree& tree);
  void evaluate_stage(Evaluator& evaluate, int stage, double t, double h) noexcept;
  bool met(int nv, const double* u, const double* dissipating, const double* giving) const noexcept;
  double taken(int nv, double h, const double* u_after) const noexcept;
  double spent(const Array& force, int nv, double h) const noexcept;

  long nq_max_, nv_max_;
  Array q_, p_;                            // stage, then result
  Array known_;                            // p*
  Array qdot_, pdot_, resist_, velocity_;  // of the stages: q̇, ṗ without the implicit forces, the implicit forces, u
  Array dissipating_, giving_;             // of the stages: forces of friction and soft stops, and of position control
  Array damping_, slope_, point_, force_, at_point_;  // the resisting forces and their slopes at the velocities `point_`
  Tree massive_;                                      // the same tree with γ h C added to the armatures
  double* massive_armature_ = nullptr;                // its armatures
  std::optional<std::uint64_t> revision_;
};

inline Damped::Damped(const Tree& tree, const StepControl& control)
    : Integrator(tree, control), nq_max_(7L * tree.bodies()), nv_max_(6L * tree.bodies()), q_(scratch(nq_max_)) {
  for (Array* one : {&p_, &known_, &damping_, &slope_, &point_, &force_, &at_point_}) *one = scratch(nv_max_);
  for (Array* one : {&pdot_, &resist_, &velocity_, &dissipating_, &giving_}) *one = scratch(stages * nv_max_);
  qdot_ = scratch(stages * nq_max_);
  follow(tree);
}

inline void Damped::follow(const Tree& tree) {
  massive_.edit().copy_with_armatures(tree);
  massive_armature_ = massive_.edit().armature();
  revision_ = tree.revision();
}

// A stage at q_, from known_: linearises the resisting forces, and again if the solution is elsewhere (Newton). The remaining
// error goes to the explicit part, so that the sum is exact.
inline void Damped::evaluate_stage(Evaluator& evaluate, int stage, double t, double h) noexcept {
  const Tree& tree = evaluate.tree();
  const Workspace<double>& workspace = evaluate.workspace();
  const int nv = tree.nv();
  const double *armature = tree.tables().armature.data(), *u = workspace.v.get();
  double *massive_armature = massive_armature_, *resist = rate(resist_, stage), *dissipating = rate(dissipating_, stage),
         *giving = rate(giving_, stage);
  const bool linear = tree.joints_with().forces.empty();
  std::copy_n(rate(velocity_, stage - 1), nv, point_.get());
  for (int left = most_linearised; left > 0; --left) {
    resisting_forces(tree, t, q_.get(), point_.get(), {force_.get(), at_point_.get(), slope_.get()});
    for (std::size_t i = 0; i < static_cast<std::size_t>(nv); ++i) {
      at_point_[i] += force_[i];
      massive_armature[i] = armature[i] + gamma * h * (damping_[i] + slope_[i]);
      p_[i] = known_[i] + gamma * h * (at_point_[i] + slope_[i] * point_[i]);
    }
    evaluate.without_resistance(massive_, t, q_.get(), p_.get());
    resisting_forces(tree, t, q_.get(), u, {dissipating, giving, force_.get()});
    if (linear || met(nv, u, dissipating, giving)) break;
    if (left > 1) move_point(tree, t, q_.get(), u, point_.get());
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(nv); ++i) {
    const double found = at_point_[i] - slope_[i] * (u[i] - point_[i]);
    resist[i] = found - damping_[i] * u[i];
    rate(pdot_, stage)[i] = workspace.pdot[i] + (dissipating[i] + giving[i] - found);
  }
}

// True if the forces at the velocities found equal their linearisation there, up to rounding.
inline bool Damped::met(int nv, const double* u, const double* dissipating, const double* giving) const noexcept {
  for (std::size_t i = 0; i < static_cast<std::size_t>(nv); ++i) {
    const double force = dissipating[i] + giving[i], line = at_point_[i] - slope_[i] * (u[i] - point_[i]);
    const double size = std::fabs(force) + std::fabs(at_point_[i]), steep = slope_[i] * (std::fabs(u[i]) + std::fabs(point_[i]));
    if (!(std::fabs(force - line) <= 1e-8 * size + 1e-13 * steep)) return false;
  }
  return true;
}

inline bool Damped::step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept {
  const Tree& tree = evaluate.tree();
  const Workspace<double>& workspace = evaluate.workspace();
  begin_step(evaluate, state, h);
  if (revision_ != tree.revision()) follow(tree);
  const int nq = tree.nq(), nv = tree.nv();
  const double *q = state.q().data(), *p = state.p().data();
  joint_damping(tree, damping_.get());

  double done = 0, lost = 0;  // work, and dissipation, of the explicit forces
  for (int s = 0; s < stages; ++s) {
    const double t = state.time() + c[s] * h;
    double *u = rate(velocity_, s), *pdot = rate(pdot_, s);
    if (s == 0) {  // the state's own evaluation, including all resisting forces
      resisting_forces(tree, t, q, workspace.v.get(), {rate(dissipating_, 0), rate(giving_, 0), slope_.get()});
      for (std::size_t i = 0; i < static_cast<std::size_t>(nv); ++i)
        pdot[i] = workspace.pdot[i] + damping_[i] * workspace.v[i] - dissipating_[i] - giving_[i];
    } else {
      std::copy_n(q, nq, q_.get());
      std::copy_n(p, nv, known_.get());
      for (int j = 0; j < s; ++j) {
        const double e = h * explicit_part[s][j], im = h * implicit_part[s][j];
        for (int i = 0; i < nq; ++i) q_[static_cast<std::size_t>(i)] += e * (qdot_.get() + j * nq_max_)[i];
        if (j == 0)
          for (int i = 0; i < nv; ++i) known_[static_cast<std::size_t>(i)] += e * rate(pdot_, 0)[i];
        else
          for (int i = 0; i < nv; ++i) known_[static_cast<std::size_t>(i)] += e * rate(pdot_, j)[i] + im * rate(resist_, j)[i];
      }
      evaluate_stage(evaluate, s, t, h);
      for (std::size_t i = 0; i < static_cast<std::size_t>(nv); ++i) p_[i] = known_[i] + gamma * h * rate(resist_, s)[i];
    }
    std::copy_n(workspace.qdot.get(), nq, qdot_.get() + s * nq_max_);
    std::copy_n(workspace.v.get(), nv, u);
    if (s + 1 == stages) continue;
    const double share = h * explicit_part[stages - 1][s];
    lost += share * workspace.power.dissipated;
    const bool driven = s > 0 && (!tree.joints_with().motions.empty() || tree.loops().motions > 0);
    if (driven) evaluate(t, q_.get(), p_.get());  // a motion's effort depends on accelerations with the true mass
    done += share * workspace.power.work;
    for (int i = 0; i < nv && s == 0; ++i)
      lost -= share * (damping_[static_cast<std::size_t>(i)] * u[i] - rate(dissipating_, 0)[i]) * u[i];
    for (int i = 0; i < nv && (s == 0 || driven); ++i) done -= share * rate(giving_, s)[i] * u[i];
  }
  end_step(tree, state.time() + h, q_.get(), p_.get());
  if (!sound(tree, q, q_.get(), p_.get()) || !close(evaluate, state.time() + h, q_.get(), p_.get())) return false;
  take_stored(tree, q, q_.get(), ledger);
  const State::Edit edit = state.edit();
  std::copy_n(q_.get(), nq, edit.q.begin());
  std::copy_n(p_.get(), nv, edit.p.begin());
  edit.time += h;
  ledger.dissipated += taken(nv, h, rate(velocity_, stages - 1)) + lost;
  ledger.work += done;
  if (!tree.joints_with().forces.empty()) {
    ledger.dissipated -= spent(dissipating_, nv, h);
    ledger.work += spent(giving_, nv, h);
  }
  book_closing(evaluate, state, ledger);
  return true;
}

// Energy taken by the dampers: ∫ c u² dt. Known of u are the end values and, from the impulse I of the damper, the mean I/(h c).
// If u changes by less than the mean, the parabola through them is integrated. If a joint comes to rest within the step, the
// impulse is used instead: ∫ u dI, with u falling in proportion.
inline double Damped::taken(int nv, double h, const double* u_after) const noexcept {
  double sum = 0;
  for (int i = 0; i < nv; ++i) {
    const double damping = damping_[static_cast<std::size_t>(i)];
    if (damping == 0) continue;
    double mean = 0;
    for (int j = 0; j < stages; ++j) mean += implicit_part[stages - 1][j] * rate(velocity_, j)[i];
    const double before = velocity_[static_cast<std::size_t>(i)], after = u_after[i], change = after - before,
                 bend = 0.5 * (before + after) - mean;
    const double square = std::fabs(change) <= std::fabs(mean) ? mean * mean + change * change / 12 + bend * bend / 5
                                                               : 0.5 * (before + after) * mean;
    sum += h * damping * square;
  }
  return sum;
}

// Energy of the stages' forces, ∫ f u dt: from their power or, if a joint nearly comes to rest within the step, from their
// impulse.
inline double Damped::spent(const Array& force, int nv, double h) const noexcept {
  double sum = 0;
  for (int i = 0; i < nv; ++i) {
    double mean = 0, impulse = 0, power = 0;
    for (int j = 1; j < stages; ++j) {
      const double share = implicit_part[stages - 1][j], u = rate(velocity_, j)[i], f = rate(force, j)[i];
      mean += share * u, impulse += share * f, power += share * f * u;
    }
    const double before = velocity_[static_cast<std::size_t>(i)], after = rate(velocity_, stages - 1)[i];
    sum += h * (std::fabs(after - before) <= std::fabs(mean) ? power : 0.5 * (before + after) * impulse);
  }
  return sum;
}

}  // namespace momentree
