// The steps of loops put together, in double.
#include <momentree/dynamics/loop_system.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/velocity.hpp>

namespace momentree {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

namespace detail {

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

void LoopCorrection::evaluate_damped(const double* q, const double* u, double damping) noexcept {
  gather(q, u);
  LoopWorkspace& loops = *workspace.loops;
  const auto each_row = [&](const auto& act) {
    for (std::size_t link = 0; link < tree.loop_links().size(); ++link)
      for (int i = 0; i < tree.loop_links()[link].rows; ++i) {
        const auto row = at(tree.loop_links()[link].first_row + i);
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
  if (tree.loop_armatures() > 0) detail::soften<double>(loops);
  if (choose) {
    detail::scale_rows<double>(tree, workspace, loops);
    detail::choose_rows(tree, loops, detail::rank_tolerance);
  }
  detail::factorise_loops<double>(loops);
  detail::solve_chosen<double>(
      loops, [&](std::size_t row) { return -loops.b[row] + (velocities ? loops.rows[row].jump_to : -loops.rows[row].drift); });
  detail::apply_multipliers<double>(tree, q, workspace, loops);
  loops.impulsive = velocities;
  loops.struck = -1;
  loops.least = false;
}

void solve_with_loops(const Tree& tree, const double* q, Workspace<double>& workspace, double* u) noexcept {
  for (const int b : tree.order()) workspace.biases[at(b)] = {};
  std::copy_n(u, tree.nv(), workspace.a.get());
  reduce_accelerations<double, true>(tree, q, workspace);
  for (LoopRow& row : workspace.loops->rows) row.jump_to = 0;
  solve_loops(tree, q, workspace, {}, LoopRows::choose, true);
  resolve_accelerations<double, true>(tree, q, workspace, {});
  std::copy_n(workspace.a.get(), tree.nv(), u);
}

std::span<const int> chosen_rows(const Tree& tree, const Workspace<double>& workspace) noexcept {
  if (!tree.has_loops() || workspace.loops == nullptr || workspace.loops->topology != tree.revision()) return {};
  return workspace.loops->kept.rows;
}

void copy_chosen_rows(const Tree& tree, const Workspace<double>& from, Workspace<double>& to) noexcept {
  if (!tree.has_loops()) return;
  LoopWorkspace& loops = detail::loop_memory(tree, to);
  loops.kept = from.loops->kept, loops.least_pivots = from.loops->least_pivots, loops.turns = from.loops->turns;
  loops.rank = from.loops->rank;
}

}  // namespace momentree
