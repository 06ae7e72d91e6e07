#pragma once
// Explicit Runge–Kutta methods with embedded error estimates and step size control. Each tableau is one file in kinds/.
//
// The error is measured in coordinates and velocities. For a state in momenta the estimated error of these, Δp, is converted to
// velocities by one solve, Δu = H⁻¹ Δp: an evaluation in a separate workspace, linear in Δp, so that nothing cancels.
//
// The last stage is the first of the next step: it is evaluated on the new state itself, and the caller's workspace then carries
// that state's stamp. If an event or a stop changes the state afterwards, the stamp is stale and the caller evaluates again.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/loops/loop_momenta.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/integrate/floating_centres.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/integrate/singular_position.hpp>

namespace momentree {

/// A tableau has `stages` (the last one at the new state), `order`, `lower` (order of the estimate), a[i][j] and c[i] for i <
/// stages − 1, b[j] for j < stages − 1, `estimates` and error[e][j] for j < stages; and, if it has dense output, `dense`, the
/// weights of all stages at a fraction of the step. Dense output may need additional stages, which are evaluated on request only:
/// dense_stages of them with dense_c[i] and dense_a[i][j].
template <class Tableau>
class Embedded : public Integrator {
 public:
  static constexpr bool chooses_steps = true, takes_velocities = true, supports_contact = true, steps_through_contacts = false;
  static constexpr Variables default_variables = Variables::velocities;
  static constexpr double damper_limit = HUGE_VAL, spring_limit = HUGE_VAL;  // it shortens its steps instead
  Embedded(const Tree& tree, const StepControl& control)
      : Integrator(tree, control),
        nq_max_(7L * tree.bodies()),
        nv_max_(6L * tree.bodies()),
        q0_(scratch(nq_max_)),
        y0_(scratch(nv_max_)),
        u0_(scratch(nv_max_)),
        q_(scratch(nq_max_)),
        y_(scratch(nv_max_)),
        kq_(scratch((Tableau::stages + dense_stages()) * nq_max_)),
        ky_(scratch((Tableau::stages + dense_stages()) * nv_max_)),
        noise_q_(scratch(nq_max_)),
        noise_u_(scratch(nv_max_)),
        error_q_(scratch(nq_max_)),
        centres_(tree.bodies()),
        solver_(tree) {
    proposal_ = std::min(control.step, control.max_step);
  }

  bool adaptive() const final { return true; }

  bool step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept final {
    begin(evaluate, state, h);
    if (!stages(evaluate, state.time(), h) || !sound(evaluate.tree(), q0_.get(), q_.get(), y_.get()) ||
        !close(evaluate, state.time() + h, q_.get(), y_.get()))
      return false;
    accept(evaluate, state, ledger, h);
    evaluate(state);
    keep_last(evaluate);
    return true;
  }

  double advance(Evaluator& evaluate, State& state, EnergyLedger& ledger, double most) noexcept final {
    begin(evaluate, state, most);
    singular_.begin(evaluate);
    const double start = state.time();
    constexpr double longest_growth = 5, longest_cut = 0.2, safety = 0.9;
    const double longest =
        most <= control_.max_step * (1 + sliver) ? most : control_.max_step;  // as in next_step: avoids a sliver
    double h = longest, possible = longest;                                   // what the error allows
    bool rejected = false;
    const EnergyLedger before = ledger;
    for (;;) {
      h = h < most ? (start + h) - start : h;  // the increment of the clock after rounding
      // A requested step is taken even if it is no more than the rounding between two instants; shorter steps of the method's own
      // choice would not advance the time.
      if (rejected && !(h > shortest * std::max(std::fabs(start), control_.step))) break;
      double error = HUGE_VAL;
      const bool fine = stages(evaluate, state.time(), h) && sound(evaluate.tree(), q0_.get(), q_.get(), y_.get()) &&
                        close_well(evaluate, state.time() + h);
      if (fine) {
        accept(evaluate, state, ledger, h);
        evaluate(state);
        keep_last(evaluate);
        error = estimate(evaluate, ledger.work, h);
      }
      const double wanted = safety * std::pow(error, -1.0 / (Tableau::lower + 1));  // NaN if the error is NaN
      const double factor = wanted >= longest_cut ? std::min(wanted, longest_growth) : longest_cut;
      bool repeat = false;  // with closed stages, or with a length that suits a singular position better
      if (closed_stages_) {
        if (error <= 1) possible = std::max(possible, std::min(longest, h * factor));
        repeat = error <= 1 && misses_gap(evaluate, h, possible);
      } else if (!(error <= 1) || singular_.met(evaluate.workspace())) {
        repeat = closed_stages_ = comes_near(evaluate, longest);
        if (repeat) rejected = false, possible = longest;
      }
      if (error <= 1 && !repeat) {
        const double next = h * (rejected ? std::min(factor, 1.0) : factor);
        // A step that was short only because of its end time is no reason against a longer one.
        const bool cut = h < 0.99 * proposal_ && !rejected && factor >= 1;
        proposal_ = std::min(cut ? std::max(next, proposal_) : next, control_.max_step);
        return h;
      }
      if (fine) {
        ledger = before;
        const State::Edit edit = state.edit();
        std::copy_n(q0_.get(), nq_, edit.q.begin());
        std::copy_n(y0_.get(), nv_, edit.y.begin());
        edit.time = start;
      }
      copy_chosen_rows(evaluate.tree(), solver_, evaluate.workspace());
      if (!repeat) rejected = true, possible = h * factor;
      h = closed_stages_ ? singular_.step(possible, widest_gap()) : possible;
    }
    last_ = 0;
    return 0;
  }

  bool dense() const final {
    return requires { Tableau::dense(0.5); };
  }
  bool interpolate(Evaluator& evaluate, double theta, double* q, double* y) noexcept final {
    if constexpr (requires { Tableau::dense(theta); }) {
      if (last_ == 0 || evaluate.tree().nq() != nq_ || evaluate.tree().nv() != nv_) return false;
      extend(evaluate);
      const auto weights = Tableau::dense(theta);
      combine(nq_, q0_.get(), weights.data(), static_cast<int>(weights.size()), last_, kq_.get(), nq_max_, q);
      combine(nv_, y0_.get(), weights.data(), static_cast<int>(weights.size()), last_, ky_.get(), nv_max_, y);
      normalise(evaluate.tree(), q);
      centres_.place(q);
      if (!evaluate.tree().has_loops() || evaluate.variables() != Variables::momenta) return true;
      double energy = 0;  // momenta are those of a state only where the loops are closed
      return evaluate.in(solver_).close(start_ + theta * last_, q, y, energy);
    } else {
      return false;
    }
  }

 private:
  static constexpr double shortest = 1e-14;  // shortest step, relative to the time or to the first step
  static constexpr int dense_stages() {
    if constexpr (requires { Tableau::dense_stages; })
      return Tableau::dense_stages;
    else
      return 0;
  }

  double* kq(int j) const { return kq_.get() + j * nq_max_; }
  double* ky(int j) const { return ky_.get() + j * nv_max_; }

  // Of an evaluation at coordinates q. For floating bodies, kq_ has the rates of their centres of mass.
  void keep(int stage, const Evaluator& evaluated, const double* q) noexcept {
    std::copy_n(evaluated.workspace().qdot.get(), nq_, kq(stage));
    centres_.add_spin(q, evaluated.workspace().v.get(), kq(stage));
    std::copy_n(evaluated.ydot(), nv_, ky(stage));
    if (stage < Tableau::stages) power_[stage] = evaluated.workspace().power;
  }

  // That at the new state. With loops in momenta its rates are those of the step's own p*.
  void keep_last(const Evaluator& evaluate) noexcept {
    keep(Tableau::stages - 1, evaluate, q_.get());
    add_gauge(evaluate, q_.get(), ky(Tableau::stages - 1));
  }

  void begin(const Evaluator& evaluate, const State& state, double h) noexcept {
    begin_step(evaluate, state, h);
    nq_ = evaluate.tree().nq();
    nv_ = evaluate.tree().nv();
    std::copy_n(state.q().data(), nq_, q0_.get());
    std::copy_n(state.y().data(), nv_, y0_.get());
    std::copy_n(evaluate.workspace().v.get(), nv_, u0_.get());
    start_ = state.time();
    last_ = 0;
    singular_ = {}, closed_stages_ = false;
    centres_.begin(evaluate.tree(), q0_.get());
    keep(0, evaluate, q0_.get());
    copy_chosen_rows(evaluate.tree(), evaluate.workspace(), solver_);  // for every attempt of this step, and its dense output
  }

  // out = start + h Σ weights[j] k[j]
  static void combine(int n, const double* start, const double* weights, int count, double h, const double* k, long stride,
                      double* out) noexcept {
    std::copy_n(start, n, out);
    for (int j = 0; j < count; ++j) {
      if (weights[j] == 0) continue;
      const double w = h * weights[j], *rate = k + j * stride;
      for (int i = 0; i < n; ++i) out[i] += w * rate[i];
    }
  }

  // Evaluates stage s, at the fraction c of a step, at q_, y_. False if it should be closed and cannot be, or if all should be.
  bool stage(Evaluator& evaluate, int s, double c, double h) noexcept {
    const double t = start_ + c * h;
    if (closed_stages_ && !close_well(evaluate, t)) return false;
    evaluate(t, q_.get(), y_.get());
    keep(s, evaluate, q_.get());
    if (closed_stages_) add_gauge(evaluate, q_.get(), ky(s));
    return closed_stages_ || !singular_.possible() || !singular_.note(evaluate.workspace(), s == 1, c, h);
  }

  // Closes the loops at q_, y_, near singular positions to round-off if these are velocities.
  bool close_well(Evaluator& evaluate, double t) noexcept {
    if (!close(evaluate, t, q_.get(), y_.get())) return false;
    double rest = 0;  // energy of round-off
    return !closed_stages_ || evaluate.variables() == Variables::momenta ||
           !close_coordinates_further(evaluate.tree(), t, q_.get(), y_.get(), evaluate.workspace()) ||
           evaluate.close(t, q_.get(), y_.get(), rest);
  }

  // Locates the singular position; true if a step of length h comes near it.
  bool comes_near(Evaluator& evaluate, double h) noexcept {
    if (!singular_.possible() || !singular_.likely(h)) return false;
    const double after = 1e-3 * h;
    const double start = loop_clearance(evaluate.tree(), q0_.get(), u0_.get(), solver_);
    constexpr double whole = 1;
    combine(nq_, q0_.get(), &whole, 1, after, kq_.get(), nq_max_, q_.get());
    centres_.place(q_.get());
    evaluate.count += 2;
    return singular_.locate(start, loop_clearance(evaluate.tree(), q_.get(), u0_.get(), solver_), after, h);
  }

  // After a good step of length h: true if one of quite another length, `possible` or less, would suit the position better.
  bool misses_gap(Evaluator& evaluate, double h, double possible) noexcept {
    constexpr double tolerated = 0.15;
    ++evaluate.count;
    return singular_.correct(loop_clearance(evaluate.tree(), q_.get(), evaluate.workspace().v.get(), solver_), h) &&
           std::fabs(singular_.step(possible, widest_gap()) - h) > tolerated * h;
  }

  // The middle of the widest gap between stages, as a fraction of the step.
  static constexpr double widest_gap() {
    double widest = 0, middle = 0;
    for (const double from : Tableau::c) {
      double to = 1;
      for (const double c : Tableau::c) to = c > from ? std::min(to, c) : to;
      if (to - from > widest) widest = to - from, middle = 0.5 * (from + to);
    }
    return middle;
  }

  // Evaluates all stages but the last; the result is in q_, y_. False if there is none.
  bool stages(Evaluator& evaluate, double t, double h) noexcept {
    constexpr int inner = Tableau::stages - 1;
    for (int s = 1; s <= inner; ++s) {
      const double* weights = s < inner ? Tableau::a[s] : Tableau::b;
      combine(nq_, q0_.get(), weights, s, h, kq_.get(), nq_max_, q_.get());
      combine(nv_, y0_.get(), weights, s, h, ky_.get(), nv_max_, y_.get());
      if (s == inner) break;
      centres_.place(q_.get());
      if (!stage(evaluate, s, Tableau::c[s], h)) return false;
    }
    end_step(evaluate.tree(), t + h, q_.get(), y_.get());
    centres_.place(q_.get());
    return true;
  }

  void accept(const Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept {
    take_stored(evaluate.tree(), q0_.get(), q_.get(), ledger);
    book_closing(evaluate, state, ledger);
    const State::Edit edit = state.edit();
    std::copy_n(q_.get(), nq_, edit.q.begin());
    std::copy_n(y_.get(), nv_, edit.y.begin());
    edit.time += h;
    for (int j = 0; j < Tableau::stages - 1; ++j) {
      ledger.dissipated += h * Tableau::b[j] * power_[j].dissipated;
      ledger.work += h * Tableau::b[j] * power_[j].work;
    }
    last_ = h;
    extended_ = false;
  }

  // Evaluates the additional stages of dense output, in a separate workspace, because the caller's may hold the new state.
  void extend([[maybe_unused]] Evaluator& evaluate) noexcept {
    if constexpr (dense_stages() > 0) {
      if (extended_) return;
      extended_ = true;
      Evaluator other = evaluate.in(solver_);
      for (int s = 0; s < dense_stages(); ++s) {
        const double* weights = Tableau::dense_a[s];
        const auto place = [&] {
          combine(nq_, q0_.get(), weights, Tableau::stages + s, last_, kq_.get(), nq_max_, q_.get());
          combine(nv_, y0_.get(), weights, Tableau::stages + s, last_, ky_.get(), nv_max_, y_.get());
          centres_.place(q_.get());
        };
        place();
        if (stage(other, Tableau::stages + s, Tableau::dense_c[s], last_)) continue;
        place();  // it could not be closed
        other(start_ + Tableau::dense_c[s] * last_, q_.get(), y_.get());
        keep(Tableau::stages + s, other, q_.get());
      }
      evaluate.count += other.count;
      evaluate.seconds += other.seconds;
    }
  }

  // Largest error of a coordinate or velocity relative to its tolerance; the evaluator's workspace must hold the new state. With
  // prescribed motions also the error of the work done: the error of coordinates that merely follow a curve does not limit the
  // steps that the drive's power needs.
  double estimate(Evaluator& evaluate, double work, double h) noexcept {
    const double* u1 = evaluate.workspace().v.get();
    const bool momenta = evaluate.variables() == Variables::momenta;
    if (momenta) find_noise(evaluate);
    double found[2] = {};
    for (int e = 0; e < Tableau::estimates; ++e) {
      const double* weights = Tableau::error[e];
      const auto measure = [&](double off, double before, double after, double noise = 0) {
        const double part =
            std::fabs(off) / (control_.atol + control_.rtol * std::max(std::fabs(before), std::fabs(after)) + noise);
        if (!(part <= found[e])) found[e] = part;  // NaN is kept
      };
      for (int i = 0; i < nq_; ++i) {
        double off = 0;
        for (int j = 0; j < Tableau::stages; ++j) off += weights[j] * kq(j)[i];
        error_q_[static_cast<std::size_t>(i)] = h * off;
      }
      centres_.add_turn(q_.get(), error_q_.get());
      for (int i = 0; i < nq_; ++i) {
        const auto k = static_cast<std::size_t>(i);
        measure(error_q_[k], q0_[k], q_[k], momenta ? h * noise_q_[k] : 0);
      }
      if (!evaluate.tree().joints_with().motions.empty() || evaluate.tree().loops().motions > 0) {
        double off = 0, most = 0;
        for (int j = 0; j < Tableau::stages; ++j) {
          off += weights[j] * power_[j].work;
          most = std::max(most, std::fabs(power_[j].work));
        }
        measure(h * off, work, h * most);
      }
      double* dy = solver_.impulse.get();
      for (int i = 0; i < nv_; ++i) {
        double off = 0;
        for (int j = 0; j < Tableau::stages; ++j) off += weights[j] * ky(j)[i];
        dy[i] = h * off;
      }
      clear_driven(evaluate.tree(), dy);
      const double* du = dy;
      if (momenta) {
        evaluate.solve(q_.get(), dy, solver_);
        du = solver_.v.get();
      } else if (closed_stages_) {
        keep_loops_closed(evaluate.tree(), start_ + h, q_.get(), u1, dy, solver_);
      }
      for (int i = 0; i < nv_; ++i) measure(du[i], u0_[static_cast<std::size_t>(i)], u1[i], momenta ? noise_u_[i] : 0);
    }
    return Tableau::combine(found);
  }

  // Velocities cannot be known better than the momenta: rounding these, p (1 ± ε), moves them by as much. A few times that is
  // tolerated in addition, or else round-off would be taken for an error, and steps would shrink without end. One solve with
  // random signs; a joint's noise is the largest of its own and of those beside it, because a single sample may be zero.
  void find_noise(Evaluator& evaluate) noexcept {
    constexpr double several = 8 * 0x1p-53;
    const Tree& tree = evaluate.tree();
    double* dp = solver_.impulse.get();
    for (int i = 0; i < nv_; ++i) {
      const std::uint64_t bits = (std::bit_cast<std::uint64_t>(y_[i]) + static_cast<unsigned>(i)) * 0x9e3779b97f4a7c15u;
      dp[i] = (bits >> 63 != 0 ? several : -several) * y_[i];
    }
    clear_driven(tree, dp);
    evaluate.solve(q_.get(), dp, solver_);
    double* const of_body = solver_.passive.get();
    for (const int b : tree.order()) {
      of_body[b] = 0;
      for (int i = 0; i < info(tree.kind(b)).nv; ++i)
        of_body[b] = std::max(of_body[b], std::fabs(solver_.v[static_cast<std::size_t>(tree.first_p(b) + i)]));
    }
    const auto put = [&](int b, double noise) {
      const KindInfo& kind = info(tree.kind(b));
      std::fill_n(noise_u_.get() + tree.first_p(b), kind.nv, noise);
      std::fill_n(noise_q_.get() + tree.first_q(b), kind.nq, noise);
    };
    for (const int b : tree.order()) {  // inboard before outboard
      const int outer = tree.parent(b);
      put(b, std::max(of_body[b], outer < 0 ? 0.0 : of_body[outer]));
      if (outer >= 0 && info(tree.kind(outer)).nv > 0) put(outer, std::max(noise_u_[tree.first_p(outer)], of_body[b]));
    }
  }

  long nq_max_, nv_max_;
  int nq_ = 0, nv_ = 0;
  std::unique_ptr<double[]> q0_, y0_, u0_;  // start of the step
  std::unique_ptr<double[]> q_, y_;         // stage, then result
  std::unique_ptr<double[]> kq_, ky_;       // rates of the stages
  std::unique_ptr<double[]> noise_q_, noise_u_, error_q_;
  FloatingCentres centres_;
  Power power_[Tableau::stages]{};
  Workspace<double> solver_;
  double start_ = 0, last_ = 0;  // start and length (s) of the step to which kq_, ky_ belong
  bool extended_ = false;        // including the stages of dense output
  SingularPosition singular_;    // near which
  bool closed_stages_ = false;   // loops are closed before each stage
};

}  // namespace momentree
