#pragma once
// Steps of worlds with closed loops or exact couplings, in lanes, in velocities; included only by instantiate/*.cpp. Each lane
// has the rows that a Simulation of its world would choose, so that no world depends on those beside it.
#include <momentree/batch/stepper.ipp>
#include <momentree/dynamics/loops/loop_place.ipp>
#include <momentree/dynamics/steps/generic_steps.ipp>
#include <momentree/dynamics/velocity.ipp>

namespace momentree::batch {

template <class T>
class PackLoopLanes final : public PackStepper<T, LoopLanes> {
  static constexpr int N = T::lanes;

 public:
  /// `width`: of the machine code for lanes like these.
  PackLoopLanes(const Tree& tree, StepWidth width) : PackStepper<T, LoopLanes>(tree), width_(width) {}
  PlanScalars scalars() const override { return {{}, step_scalar<T, Passes::velocities>(width_)}; }
  void fit(const Tree& tree) override {
    detail::lay_out_loops<T>(tree, loops_);
    choice_.fit(tree);
  }

 private:
  using Mask = typename T::Mask;

  void begin(const Tree& tree, const TopologyPlan& plan, const Block& block) noexcept override {
    this->workspace_.kept_steps = plan.kept_steps.get();
    if (loops_.topology != tree.loops().revision()) fit(tree);
    const std::size_t count = tree.loops().size();
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t l = 0; l < N; ++l) loops_.turns[i * N + l] = block.turns[l * count + i];
    loops_.lanes = 0;
    for (int l = 0; l < N; ++l) loops_.lanes |= block.h[l] != 0 ? 1u << l : 0u;
    choosing_ = true;
  }

  void evaluate(const Tree& tree, const TopologyPlan& plan, const double* effort, const double* t, const T* q,
                const T* u) noexcept override {
    Workspace<T>& workspace = this->workspace_;
    sweep_velocities<T, true>(tree, q, u, workspace);
    T* const tau = workspace.a.get();
    for (int i = 0; i < tree.nv(); ++i) tau[i] = T(0);
    this->add_forces(tree, plan, effort, t, q, tau);
    if (tree.loops().motions > 0) detail::set_loop_motions(tree, t, N, loops_);
    place(tree, q, choosing_ ? LoopRows::choose : LoopRows::kept);
    Power unused[N];
    detail::add_loop_forces<T>(tree, t, workspace, loops_, unused);
    const Vec3& g = tree.gravity();
    const Motion<T> base{{T(-g.x), T(-g.y), T(-g.z)}, {T(0), T(0), T(0)}};
    gather(tree, q, base, choosing_);
    choosing_ = false;
    detail::solve_chosen<T>(loops_, [&](std::size_t row) { return -(loops_.b[row] + loops_.rows[row].drift); });
    detail::apply_multipliers<T>(tree, q, workspace, loops_);
    resolve_accelerations<T, true>(tree, q, workspace, base);
  }
  const T* ydot() const noexcept override { return this->workspace_.a.get(); }

  // See close_loops in dynamics/loops/loop_closing.cpp.
  void close(const Tree& tree, const Block& block, const double* t, Mask& plausible) noexcept override {
    Workspace<T>& workspace = this->workspace_;
    T *const q = this->q_.get(), *const u = this->y_.get();
    if (tree.loops().motions > 0) detail::set_loop_motions(tree, t, N, loops_);
    double before[N];
    bool working[N];
    for (int l = 0; l < N; ++l) before[l] = HUGE_VAL, working[l] = plausible[l] != 0 && block.h[l] != 0;
    for (int k = 0;; ++k) {
      evaluate_without_forces(tree, q, u);
      bool any = false;
      for (int l = 0; l < N; ++l) {
        if (!working[l]) continue;
        const double open = detail::most_open(tree, loops_, l);
        working[l] = open > detail::closed && open < 0.5 * before[l] && k < detail::most_corrections;
        if (!working[l] && !(open <= detail::nearly_closed)) plausible[l] = 0;
        before[l] = open;
        any = any || working[l];
      }
      if (!any) break;
      correct(tree, q, [&](std::size_t row) { return -loops_.rows[row].residual; });
      for (int i = 0; i < tree.nv(); ++i)
        for (int l = 0; l < N; ++l)
          if (!working[l]) workspace.a[i].set(l, 0);
      displace(tree, q, working);
    }
    correct(tree, q, [&](std::size_t row) { return -loops_.rows[row].velocity; });
    for (int i = 0; i < tree.nv(); ++i) u[i] += workspace.a[i];
    const std::size_t count = tree.loops().size();
    for (std::size_t i = 0; i < count; ++i)
      for (int l = 0; l < N; ++l)
        if (plausible[l] != 0 && block.h[l] != 0) {
          Turns& turns = block.turns[static_cast<std::size_t>(l) * count + i];
          turns = detail::turns_at(tree, static_cast<int>(i), lane_of(loops_.places[i], l), turns_hint(i, l));
        }
  }
  const Turns& turns_hint(std::size_t loop, int lane) const { return loops_.turns[loop * N + static_cast<std::size_t>(lane)]; }

  void place(const Tree& tree, const T* q, LoopRows which) noexcept {
    detail::place_closures<T>(tree, q, this->workspace_, loops_, true, which);
    detail::place_other_rows<T>(tree, q, this->workspace_, loops_, true);
  }
  // The inward pass, and the factor of the rows.
  void gather(const Tree& tree, const T* q, const Motion<T>& base, bool choose) noexcept {
    reduce_accelerations<T, true>(tree, q, this->workspace_);
    detail::gather_loops<T>(tree, q, this->workspace_, loops_, base, choose);
    if (tree.loops().armatures > 0) detail::soften<T>(loops_);
    if (choose) {
      detail::scale_rows<T>(tree, this->workspace_, loops_);
      choice_.choose<T>(tree, loops_);
    }
    detail::factorise_loops<T>(loops_);
  }
  // As LoopCorrection::evaluate.
  void evaluate_without_forces(const Tree& tree, const T* q, const T* u) noexcept {
    Workspace<T>& workspace = this->workspace_;
    sweep_velocities<T, true>(tree, q, u, workspace);
    for (const int b : tree.order()) workspace.biases[static_cast<std::size_t>(b)] = {};
    for (int i = 0; i < tree.nv(); ++i) workspace.a[i] = T(0);
    place(tree, q, LoopRows::choose);
    gather(tree, q, {}, true);
  }
  // H⁻¹ Jᵀ λ to workspace.a, for A λ = right(row).
  template <class Right>
  void correct(const Tree& tree, const T* q, const Right& right) noexcept {
    detail::solve_chosen<T>(loops_, right);
    detail::apply_multipliers<T>(tree, q, this->workspace_, loops_);
    resolve_accelerations<T, true>(tree, q, this->workspace_, {});
  }
  // q ← q + N(q) δ in the lanes that work.
  void displace(const Tree& tree, T* q, const bool* working) noexcept {
    const T* const delta = this->workspace_.a.get();
    for (const int b : tree.order())
      dispatch(tree.kind(b), [&](auto tag) {
        using K = typename decltype(tag)::type;
        if constexpr (K::info.nv > 0) {
          T rate[7];
          T* const own = q + tree.first_q(b);
          K::Kernels::template coordinate_rate<T>(own, delta + tree.first_p(b), rate);
          for (int i = 0; i < K::info.nq; ++i) own[i] += rate[i];
        }
      });
    this->normalise(tree, q, working);
  }

  StepWidth width_;
  detail::LaneChoice choice_;
  LoopSystem<T> loops_;
  bool choosing_ = true;
};

}  // namespace momentree::batch
