#include <momentree/generate/loop_kernel.hpp>

#include <algorithm>
#include <new>
#include <tuple>

#include <momentree/dynamics/forces/linear_spring.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/generate/recording.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/motion.hpp>

namespace momentree {

// In instantiate/.
#define MOMENTREE_LOOPS_OF(T)                                                                                                    \
  extern template void sweep_velocities<T, true>(const Tree&, const T*, const T*, Workspace<T>&) noexcept;                       \
  extern template void reduce_accelerations<T, true>(const Tree&, const T*, Workspace<T>&) noexcept;                             \
  extern template void resolve_accelerations<T, true>(const Tree&, const T*, Workspace<T>&, const Motion<T>&) noexcept;          \
  extern template void detail::place_closures<T>(const Tree&, const T*, Workspace<T>&, LoopSystem<T>&, bool, LoopRows) noexcept; \
  extern template void detail::soften<T>(LoopSystem<T>&) noexcept;                                                               \
  extern template void detail::gather_loops<T>(const Tree&, const T*, Workspace<T>&, LoopSystem<T>&, const Motion<T>&,           \
                                               bool) noexcept;                                                                   \
  extern template void detail::apply_multipliers<T>(const Tree&, const T*, Workspace<T>&, LoopSystem<T>&) noexcept;
MOMENTREE_LOOPS_OF(Symbolic)
#undef MOMENTREE_LOOPS_OF

namespace {

using detail::resting, detail::take;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Systems of n rows that need more multiplications are solved by a call, in loops: dense ones with more than 15 rows.
constexpr long most_in_place(std::size_t n) { return 400 + 20 * static_cast<long>(n); }

// True if the columns of a joint do not depend on its coordinates, so that the row of a DoF is constant in the child's frame. So
// it is for all kinds that can have a prescribed motion. Functions of kernels are inlined (flatten): they are not defined here.
[[gnu::flatten]] bool has_constant_columns(const JointSpec& joint) {
  const Values zero = joint_zero(joint.kind);
  double q[7] = {};
  for (int i = 0; i < zero.size(); ++i) q[i] = zero[i] + 0.5;
  Motion<double> one[6], other[6];
  const int n = joint_columns(joint, zero.begin(), one);
  joint_columns(joint, q, other);
  double change = 0;
  for (int i = 0; i < n; ++i) change += norm(one[i].v - other[i].v) + norm(one[i].w - other[i].w);
  return change < 1e-12;
}

// One recording of the passes with loops.
class LoopRecording {
  using T = Symbolic;

 public:
  LoopRecording(const Tree& tree, std::span<const int> rows, LoopCode code, Expressions& all)
      : tree_(tree), code_(code), all_(all), workspace_(tree) {
    detail::lay_out_loops<T>(tree, loops_);
    loops_.lanes = 0;
    detail::record_kept_steps(tree, workspace_);
    detail::lay_out(tree, {rows.begin(), rows.end()}, loops_.kept);
  }

  void record(bool plain_forces, KernelExpressions& kernel) {
    const std::vector<bool> rests = resting(tree_);
    for (int i = 0; i < tree_.nq(); ++i) q_.push_back(T::of_node(all_.input(Operation::q, i)));
    for (int i = 0; i < tree_.nv(); ++i) u_.push_back(rests[at(i)] ? T(0) : T::of_node(all_.input(Operation::p, i)));
    sweep_velocities<T, true>(tree_, q_.data(), u_.data(), workspace_);
    put_joint_forces(rests, plain_forces);
    detail::place_closures<T>(tree_, q_.data(), workspace_, loops_, true, LoopRows::kept);
    for (std::size_t i = 0; i < tree_.loops().size(); ++i) complete_loop(i);
    for (std::size_t i = tree_.loops().size(); i < tree_.loops().links.size(); ++i) place_coupling(tree_.loops().links[i]);
    const Vec3& g = tree_.gravity();
    const Motion<T> base{{T(-g.x), T(-g.y), T(-g.z)}, {T(0), T(0), T(0)}};
    reduce_accelerations<T, true>(tree_, q_.data(), workspace_);
    detail::gather_loops<T>(tree_, q_.data(), workspace_, loops_, base, false);
    if (tree_.loops().armatures > 0) detail::soften<T>(loops_);
    solve();
    detail::apply_multipliers<T>(tree_, q_.data(), workspace_, loops_);
    resolve_accelerations<T, true>(tree_, q_.data(), workspace_, base);
    take(workspace_.qdot, tree_.nq(), kernel.qdot);
    take(workspace_.a, tree_.nv(), kernel.udot);
    if (code_ == LoopCode::file) return;
    for (const int row : loops_.kept.rows) kernel.lambda.push_back(loops_.lambda[at(row)].node());
    for (const int b : tree_.joints_with().motions) kernel.effort.push_back(motion_effort(b).node());
  }

  const std::vector<int>& begin() const { return loops_.kept.begin; }

 private:
  void put_joint_forces(const std::vector<bool>& rests, bool plain_forces) {
    for (int i = 0; i < tree_.nv(); ++i) {
      T& tau = workspace_.a[at(i)];
      tau = rests[at(i)] ? T(0) : T::of_node(all_.input(Operation::tau, i));
      if (plain_forces && !rests[at(i)]) tau += tree_.tables().effort[at(i)] - tree_.tables().damping[at(i)] * u_[at(i)];
    }
    if (!plain_forces) return;
    for (const forces::LinearSpring& spring : forces::linear_springs(tree_))
      workspace_.a[at(spring.p)] -= spring.stiffness * (q_[at(spring.q)] - spring.rest);
  }

  // The rows of single DoFs, and the forces in the joint.
  void complete_loop(std::size_t place) {
    const LoopLink& link = tree_.loops().links[place];
    const bool forces = code_ == LoopCode::stages && detail::has_forces(tree_.loops()[place]);
    const bool known = has_constant_columns(spec_of(tree_.loops()[place].joint));
    if (known)
      for (int k = 0; k < link.dof_row_count; ++k) place_constant_row(place, k);
    const int rows = known ? 0 : link.dof_row_count;
    if (!forces && rows == 0) return;
    const LoopPlaceOf<T>& p = loops_.places[place];
    std::vector<int> arguments;
    const auto* const numbers = reinterpret_cast<const T*>(&p);
    for (std::size_t i = 0; i < sizeof p / sizeof(T); ++i) arguments.push_back(numbers[i].node());
    const int first = all_.call(static_cast<int>(place), std::move(arguments), loop_answers(rows));
    int next = first;
    const auto answer = [&] { return T::of_node(next++); };
    const auto vector = [&] {
      Vector3<T> a;
      a.x = answer(), a.y = answer(), a.z = answer();
      return a;
    };
    const Vector3<T> force = vector(), torque = vector();
    if (forces) apply_force(place, force, torque);
    for (int k = 0; k < rows; ++k) {
      LoopRowOf<T>& row = loops_.rows[at(link.first_row + link.closure.rows() + k)];
      row.F = vector(), row.T = vector(), row.drift = answer(), row.softness = answer();
    }
  }
  void apply_force(std::size_t place, const Vector3<T>& force, const Vector3<T>& torque) {
    const Loop& loop = tree_.loops()[place];
    const auto on = [&](int body) { return on_body(workspace_.bodies[at(body)], force, torque, loops_.places[place].xb); };
    Force<T>& child = workspace_.biases[at(loop.body)].wrench;
    child = child - on(loop.body);
    if (loop.to >= 0) workspace_.biases[at(loop.to)].wrench += on(loop.to);
  }
  // As detail::dof_row, where the row is constant in the child's frame.
  void place_constant_row(std::size_t place, int k) {
    const LoopLink& link = tree_.loops().links[place];
    const DofRow& of = link.dof_rows[at(k)];
    const LoopPlaceOf<T>& p = loops_.places[place];
    const JointSpec spec = spec_of(tree_.loops()[place].joint);
    const Motion<double> w = detail::dof_direction(spec, joint_zero(spec.kind).begin(), of.dof);
    const Matrix3<T> Rb = p.Ra * (p.R * transpose(rotation_matrix(link.child_offset.rotation)));
    const Vector3<T> v = p.vb - p.va - cross(p.wa, p.xb - p.xa), relative = p.wb - p.wa;
    LoopRowOf<T>& row = loops_.rows[at(link.first_row + link.closure.rows() + k)];
    row.F = Rb * w.v, row.T = Rb * w.w;
    row.drift = dot(cross(p.wb, row.F), v) + dot(row.F, cross(relative, p.vb)) + dot(cross(p.wb, row.T), relative);
    if (of.use == DofRow::Use::motion) row.drift -= T::of_node(all_.input(Operation::tau, tree_.nv() + motions_++));
    row.softness = T(of.use == DofRow::Use::armature ? 1 / of.armature : 0.0);
  }

  void place_coupling(const LoopLink& link) {
    const Coupling& c = tree_.couplings()[at(link.ends.coupling)];
    LoopRowOf<T>& row = loops_.rows[at(link.first_row)];
    row.F = row.T = {};
    row.slope = row.drift = T(0);
    if (!c.leads()) return;
    const T x = q_[at(tree_.first_q(link.ends.follows))], rate = workspace_.v[at(tree_.first_p(link.ends.follows))];
    const auto& h = c.higher;
    row.slope = c.multiplier + x * (2 * h[0] + x * (3 * h[1] + x * T(4 * h[2])));
    row.drift = -((2 * h[0] + x * (6 * h[1] + x * T(12 * h[2]))) * (rate * rate));
  }

  // A λ = −(b + drift) by a factorisation L D Lᵀ, which divides once per row.
  void solve() {
    const LoopLayout& kept = loops_.kept;
    const std::size_t n = kept.rows.size();
    std::vector<T> right(n);
    for (std::size_t i = 0; i < n; ++i) right[i] = -(loops_.b[at(kept.rows[i])] + loops_.rows[at(kept.rows[i])].drift);
    for (T& lambda : loops_.lambda) lambda = T(0);
    long products = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const long width = static_cast<long>(i) - kept.begin[i] + 1;
      products += width * (width + 1) / 2;
    }
    const std::vector<T> lambda = products <= most_in_place(n) ? solved_in_place(right) : solved_by_call(right);
    for (std::size_t i = 0; i < n; ++i) loops_.lambda[at(kept.rows[i])] = lambda[i];
  }
  std::vector<T> solved_in_place(std::vector<T> x) {
    const LoopLayout& kept = loops_.kept;
    const auto n = static_cast<std::ptrdiff_t>(x.size());
    std::vector<T> L(kept.elements), inverse(x.size());
    const auto element = [&](auto& all, std::ptrdiff_t i, std::ptrdiff_t j) -> T& {
      return all[static_cast<std::size_t>(kept.position[static_cast<std::size_t>(i)] + j)];
    };
    const auto begin = [&](std::ptrdiff_t i) -> std::ptrdiff_t { return kept.begin[static_cast<std::size_t>(i)]; };
    std::vector<T> w(x.size());  // D L of the row at hand
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      T pivot = element(loops_.A, i, i);
      for (std::ptrdiff_t j = begin(i); j < i; ++j) {
        T s = element(loops_.A, i, j);
        for (std::ptrdiff_t k = std::max(begin(i), begin(j)); k < j; ++k) s -= w[static_cast<std::size_t>(k)] * element(L, j, k);
        w[static_cast<std::size_t>(j)] = s;
        element(L, i, j) = s * inverse[static_cast<std::size_t>(j)];
        pivot -= s * element(L, i, j);
      }
      inverse[static_cast<std::size_t>(i)] = T::of_node(all_.inverse_pivot(pivot.node(), static_cast<int>(i)));
      for (std::ptrdiff_t j = begin(i); j < i; ++j)
        x[static_cast<std::size_t>(i)] -= element(L, i, j) * x[static_cast<std::size_t>(j)];
    }
    for (std::ptrdiff_t i = 0; i < n; ++i)
      x[static_cast<std::size_t>(i)] = x[static_cast<std::size_t>(i)] * inverse[static_cast<std::size_t>(i)];
    for (std::ptrdiff_t i = n; i-- > 0;)
      for (std::ptrdiff_t j = begin(i); j < i; ++j)
        x[static_cast<std::size_t>(j)] -= element(L, i, j) * x[static_cast<std::size_t>(i)];
    return x;
  }
  // The elements of A in their order in memory, then the right side.
  std::vector<T> solved_by_call(const std::vector<T>& right) {
    std::vector<int> arguments;
    for (std::size_t i = 0; i < loops_.kept.elements; ++i) arguments.push_back(loops_.A[i].node());
    for (const T& x : right) arguments.push_back(x.node());
    const int first = all_.call(-1, std::move(arguments), static_cast<int>(right.size()));
    std::vector<T> x;
    for (int i = 0; i < static_cast<int>(right.size()); ++i) x.push_back(T::of_node(first + i));
    return x;
  }

  // As motion_effort, with all that acts along the DoF besides the constraint.
  T motion_effort(int b) {
    const UncheckedTree all(tree_);
    Force<T> Tr = workspace_.reduced_bias_wrenches[at(b)];
    T effort = tree_.tables().armature[at(tree_.first_p(b))] * workspace_.a[at(tree_.first_p(b))];
    dispatch_kernels(tree_.kind(b), tree_.variant(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      K::add_reduced(workspace_.template record<K>(all, b), workspace_.inboard_accelerations[at(b)], Tr);
      const auto E = K::template columns<T>(all.link(b), joint_state(all, q_.data(), workspace_, b));
      if constexpr (std::tuple_size_v<std::remove_cv_t<decltype(E)>> != 0) effort += dot(E[0], Tr);
    });
    for (std::size_t i = tree_.loops().size(); i < tree_.loops().links.size(); ++i) {
      const LoopLink& link = tree_.loops().links[i];
      const T lambda = loops_.lambda[at(link.first_row)];
      if (link.ends.joint == b) effort -= lambda;
      if (link.ends.follows == b) effort += loops_.rows[at(link.first_row)].slope * lambda;
    }
    return effort;
  }

  const Tree& tree_;
  const LoopCode code_;
  Expressions& all_;
  std::vector<T> q_, u_;
  Workspace<T> workspace_;
  LoopSystem<T> loops_;
  int motions_ = 0;  // rows of prescribed motions so far
};

}  // namespace

KernelExpressions loop_expressions(const Tree& tree, std::span<const int> rows, LoopCode code, bool plain_forces) {
  MT_REQUIRE(tree.has_loops(), "a tree with closed loops or couplings");
  KernelExpressions kernel;
  kernel.variables = Variables::velocities;
  kernel.loops = code == LoopCode::stages;
  kernel.expressions.cancel_terms();
  Symbolic::graph() = &kernel.expressions;
  LoopRecording recording(tree, rows, code, kernel.expressions);
  recording.record(plain_forces, kernel);
  kernel.begin = recording.begin(), kernel.motions = tree.loops().motions;
  Symbolic::graph() = nullptr;
  if (kernel.expressions.exhausted()) throw std::bad_alloc();
  return kernel;
}

ChosenRows chosen_loop_rows(const Tree& tree, const State& state) {
  Workspace<double> workspace(tree);
  forward_dynamics(tree, state, workspace);
  const std::span<const int> rows = chosen_rows(tree, workspace);
  return {{rows.begin(), rows.end()},
          {workspace.loops->least_pivots.begin(), workspace.loops->least_pivots.begin() + std::ssize(rows)}};
}

std::vector<LoopObstacle> loop_obstacles(const Tree& tree, bool without_joint_forces) {
  std::vector<LoopObstacle> found;
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    if (tree.loops().links[i].dof_row_count > 0 && !has_constant_columns(spec_of(loop.joint)))
      found.push_back({static_cast<int>(i),
                       std::string("an armature or a lock of single DoFs of a ") + info(loop.joint.kind).name + " joint", false});
    if (!without_joint_forces && detail::has_forces(loop)) found.push_back({static_cast<int>(i), "a force along its DoFs", true});
  }
  return found;
}

}  // namespace momentree
