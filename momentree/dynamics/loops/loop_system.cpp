// The steps of loops put together, in double.
#include <momentree/dynamics/loops/loop_system.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/velocity.hpp>

namespace momentree {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// With larger armatures A is smaller, and some pivots more than others: rows are left out only where pivots are smaller still.
void factorise(LoopWorkspace& loops) noexcept {
  constexpr double unevenly = 1e-3;
  if (!loops.heavier || loops.whole) return detail::factorise_loops<double>(loops);
  const std::size_t n = loops.kept.rows.size();
  double *const mobility = loops.choice.mobility.data(), *const least = loops.least_pivots.data();
  std::copy_n(least, n, mobility + n);
  for (std::size_t i = 0; i < n; ++i)
    if (const double now = loops.kept.element(loops.A, i, i); now < mobility[i]) least[i] *= unevenly * now / mobility[i];
  detail::factorise_loops<double>(loops);
  std::copy_n(mobility + n, n, least);
}

}  // namespace

namespace detail {

void soften(LoopWorkspace& loops) noexcept {
  soften<double>(loops);
  if (!loops.in_momenta) return;
  for (std::size_t row = 0; row < loops.rows.size(); ++row) {
    if (!(loops.rows[row].softness > 0)) continue;
    if (loops.armatures == ArmatureSpeeds::taken) loops.speeds[row] = loops.b[row];
    loops.rows[row].jump_to = loops.armatures == ArmatureSpeeds::none ? 0 : loops.speeds[row];
  }
}

void LoopCorrection::gather(const double* q, const double* u) noexcept {
  sweep_velocities<double, true>(tree, q, u, workspace);
  for (const int b : tree.order()) workspace.biases[at(b)] = {};
  std::fill_n(workspace.a.get(), tree.nv(), 0.0);
  reduce_accelerations<double, true>(tree, q, workspace);
  place_loops(tree, q, workspace, true);
  gather_loops(tree, q, workspace, *workspace.loops, {}, true);
  soften<double>(*workspace.loops);
}

void LoopCorrection::evaluate(const double* q, const double* u, double tolerance) noexcept {
  gather(q, u);
  scale_rows(tree, workspace, *workspace.loops);
  choose_rows(tree, *workspace.loops, tolerance > 0 ? tolerance : detail::rank_tolerance);
  factorise_loops<double>(*workspace.loops);
}

void LoopCorrection::evaluate_kept(const double* q, const double* u) noexcept {
  gather(q, u);
  LoopWorkspace& loops = *workspace.loops;
  scale_rows(tree, workspace, loops);
  const std::size_t n = loops.kept.rows.size();
  double *const least = loops.least_pivots.data(), *const scratch = loops.choice.mobility.data() + n;
  std::copy_n(least, n, scratch);
  std::fill_n(least, n, 0.0);
  factorise_loops<double>(loops);
  std::copy_n(scratch, n, least);
}

void LoopCorrection::evaluate_damped(const double* q, const double* u, double damping) noexcept {
  gather(q, u);
  LoopWorkspace& loops = *workspace.loops;
  const auto each_row = [&](const auto& act) {
    for (std::size_t link = 0; link < tree.loops().links.size(); ++link)
      for (int i = 0; i < tree.loops().links[link].rows; ++i) {
        const auto row = at(tree.loops().links[link].first_row + i);
        const double size = row_size(tree, loops, link, i);
        act(loops.A[static_cast<std::size_t>(loops.all.position[row]) + row], size * size);
      }
  };
  double largest = 1e-300;
  each_row([&](double& a, double square) { largest = std::max(largest, a / square); });
  each_row([&](double& a, double square) { a += damping * largest * square; });
  loops.kept = loops.all;
  loops.rank = static_cast<int>(loops.rows.size());
  std::fill(loops.least_pivots.begin(), loops.least_pivots.end(), 0.0);
  factorise_loops<double>(loops);
}

void LoopCorrection::finish(const double* q) noexcept {
  apply_multipliers(tree, q, workspace, *workspace.loops);
  resolve_accelerations<double, true>(tree, q, workspace, {});
}

}  // namespace detail

void solve_loops(const Tree& tree, const double* q, Workspace<double>& workspace, const Motion<double>& base, LoopRows rows,
                 bool velocities) noexcept {
  LoopWorkspace& loops = *workspace.loops;  // placed with the forces
  const bool choose = rows == LoopRows::choose || loops.rank < 0;
  detail::gather_loops<double>(tree, q, workspace, loops, base, choose);
  if (tree.loops().armatures > 0) detail::soften(loops);
  if (choose) {
    detail::scale_rows<double>(tree, workspace, loops);
    detail::choose_rows(tree, loops, detail::rank_tolerance);
  }
  factorise(loops);
  detail::solve_chosen<double>(
      loops, [&](std::size_t row) { return -loops.b[row] + (velocities ? loops.rows[row].jump_to : -loops.rows[row].drift); });
  detail::apply_multipliers<double>(tree, q, workspace, loops);
  loops.impulsive = velocities;
  loops.solved = tree.revision();
  loops.strike.loop = -1;
  loops.least = false;
}

void solve_with_loops(const Tree& tree, const double* q, Workspace<double>& workspace, double* u) noexcept {
  std::copy_n(u, tree.nv(), workspace.a.get());
  for (const int b : tree.order()) {
    workspace.biases[at(b)] = {};
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)  // locks and prescribed motions take up what acts along them
      if ((tree.link(b).locked >> i & 1u) != 0) workspace.a[tree.first_p(b) + i] = 0;
  }
  reduce_accelerations<double, true>(tree, q, workspace);
  for (LoopRow& row : workspace.loops->rows) row.jump_to = 0;
  solve_loops(tree, q, workspace, {}, LoopRows::choose, true);
  resolve_accelerations<double, true>(tree, q, workspace, {});
  std::copy_n(workspace.a.get(), tree.nv(), u);
}

double loop_clearance(const Workspace<double>& workspace) noexcept {
  const LoopWorkspace& loops = *workspace.loops;
  double least = 1;
  for (std::size_t i = 0; i < loops.kept.rows.size(); ++i) {
    const double root = loops.kept.element(loops.factor, i, i);
    least = std::min(least, root < HUGE_VAL ? root * root / loops.rows[at(loops.kept.rows[i])].scale : 0.0);
  }
  return std::sqrt(least);
}

double loop_clearance(const Tree& tree, const double* q, const double* u, Workspace<double>& workspace) noexcept {
  detail::LoopCorrection{tree, workspace}.evaluate_kept(q, u);
  return loop_clearance(workspace);
}

std::span<const int> chosen_rows(const Tree& tree, const Workspace<double>& workspace) noexcept {
  if (!tree.has_loops() || workspace.loops == nullptr || workspace.loops->topology != tree.loops().revision()) return {};
  return workspace.loops->kept.rows;
}

void copy_chosen_rows(const Tree& tree, const Workspace<double>& from, Workspace<double>& to) noexcept {
  if (!tree.has_loops()) return;
  LoopWorkspace& loops = detail::loop_memory(tree, to);
  loops.kept = from.loops->kept, loops.least_pivots = from.loops->least_pivots, loops.turns = from.loops->turns;
  loops.rank = from.loops->rank, loops.speeds = from.loops->speeds;
}

}  // namespace momentree
