// The system of the loops' rows: A = J M⁻¹ Jᵀ and b from the records of the inward pass, and what its solution adds to them.
#include <momentree/dynamics/loop_system.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/velocity.hpp>
#include <momentree/dynamics/wrench_inboard.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {

constexpr double rank_tolerance = 1e-9;  // of pivots of the scaled A; those of redundant rows are below 1e-15

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Mj⁻¹ (τ − Eᵀ W), as the record holds it.
template <class K, class Record>
void read_base_velocity(const Record& record, double* u0) {
  if constexpr (requires { typename K::Steps; })
    u0[0] = record.u0;
  else
    K::joint_velocity(record, Motion<double>{}, u0);
}
template <class Record>
void add_base_velocity(Record& record, const double* du, const auto& E) {
  if constexpr (requires { record.a0; }) {
    for (std::size_t i = 0; i < E.size(); ++i) record.a0 = record.a0 + Motion<double>{du[i] * E[i].v, du[i] * E[i].w};
  } else if constexpr (requires { record.u0[0]; }) {
    for (std::size_t i = 0; i < E.size(); ++i) record.u0[i] += du[i];
  } else {
    record.u0 += du[0];
  }
}

// Calls f(first stop, end of the stops of its body) for all bodies with stops, outboard before inboard.
template <class F>
void each_body_inward(std::span<const LoopStop> stops, const F& f) {
  for (std::size_t end = stops.size(); end > 0;) {
    std::size_t first = end - 1;
    while (first > 0 && stops[first - 1].body == stops[end - 1].body) --first;
    f(first, end);
    end = first;
  }
}

}  // namespace

namespace detail {

void gather_loops(const Tree& tree, const double* q, Workspace<double>& workspace, const Motion<double>& base,
                  bool all) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  const auto stops = tree.loop_stops();
  const auto links = tree.loop_links();
  const std::size_t m = loops.rows.size();
  if (all) {
    loops.chosen.clear();
    for (std::size_t i = 0; i < m; ++i) loops.chosen.push_back(static_cast<int>(i));
  }
  std::fill(loops.position.begin(), loops.position.end(), -1);
  for (std::size_t i = 0; i < loops.chosen.size(); ++i) loops.position[at(loops.chosen[i])] = static_cast<int>(i);
  const auto used = [&](int row) { return loops.position[at(row)] >= 0; };
  std::fill(loops.A.begin(), loops.A.end(), 0.0);
  std::fill(loops.b.begin(), loops.b.end(), 0.0);

  for (const LoopStop& stop : stops) {  // the ends' own wrenches
    const LoopLink& link = links[at(stop.loop)];
    if (link.ends.coupling >= 0) {
      LoopColumn& column = loops.columns[at(stop.first_column)];
      column.K = {};
      column.effort = (stop.body == link.ends.joint ? 1.0 : 0.0) -
                      (stop.body == link.ends.follows ? loops.rows[at(link.first_row)].slope : 0.0);
      continue;
    }
    const Loop& loop = tree.loops()[at(stop.loop)];
    const LoopPlace& place = loops.places[at(stop.loop)];
    for (int i = 0; i < link.rows; ++i) {
      const LoopRow& row = loops.rows[at(link.first_row + i)];
      Force<double>& K = loops.columns[at(stop.first_column + i)].K;
      K = {};
      if (stop.body == loop.body) K += on_body(workspace.bodies[at(stop.body)], row.F, row.T, place.xb);
      if (stop.body == loop.to) K = K - on_body(workspace.bodies[at(stop.body)], row.F, row.T, place.xb);
    }
  }
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {  // the ground's ends
    if (tree.loops()[i].to >= 0) continue;
    for (int k = 0; k < links[i].rows; ++k) {
      const auto row = at(links[i].first_row + k);
      loops.b[row] -= dot(loops.rows[row].F, base.v);
    }
  }

  each_body_inward(stops, [&](std::size_t first, std::size_t end) {
    const int b = stops[first].body, nv = info(tree.kind(b)).nv;
    const LinkConstants& link = tree.link(b);
    const JointState<double> joint = joint_state(tree, q, workspace, b);
    const unsigned flags = tree.node_flags()[at(tree.place(b))];
    dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      const auto& record = workspace.record<K>(tree, b);
      double u0[6] = {};
      const auto E = K::template columns<double>(link, joint);
      if constexpr (!K::rigid) read_base_velocity<K>(record, u0);
      const Motion<double>& bias = workspace.biases[at(b)].acceleration;
      for (std::size_t s = first; s < end; ++s) {
        const LoopStop& stop = stops[s];
        const LoopLink& loop = links[at(stop.loop)];
        for (int i = 0; i < loop.rows; ++i) {
          const int row = loop.first_row + i;
          if (!used(row)) continue;
          LoopColumn& column = loops.columns[at(stop.first_column + i)];
          double& free = loops.b[at(row)];
          Force<double> W = column.K;
          if constexpr (!K::rigid) {
            double effort[6] = {column.effort};
            for (std::size_t d = 0; d < E.size(); ++d) {
              const double along = dot(E[d], W) + effort[d];
              column.k[d] = (link.locked >> d & 1u) == 0 ? along : 0.0;
              free += column.k[d] * u0[d];
              if ((link.driven >> d & 1u) != 0) free += along * u0[d];
            }
            effort[0] = (link.locked & 1u) == 0 ? -column.effort : 0.0;
            K::template reduce_wrench<double>(link, joint, record, effort, W, column.y);
            for (std::size_t d = 0; d < E.size(); ++d) column.y[d] = -column.y[d];
            column.K = W;
            free += dot(bias, W);
            wrench_inboard<K>(link, joint, record, flags, W);
          }
          if (stop.inboard >= 0)
            loops.columns[at(stops[at(stop.inboard)].first_column + i)].K += W;
          else
            free += dot(base, W);
        }
      }
    });
    for (std::size_t s = first; s < end && nv > 0; ++s)
      for (std::size_t r = first; r <= s; ++r)
        for (int i = 0; i < links[at(stops[s].loop)].rows; ++i) {
          const int row = links[at(stops[s].loop)].first_row + i;
          if (!used(row)) continue;
          const LoopColumn& one = loops.columns[at(stops[s].first_column + i)];
          for (int j = 0; j < links[at(stops[r].loop)].rows; ++j) {
            const int other = links[at(stops[r].loop)].first_row + j;
            if (!used(other) || other > row) continue;
            const LoopColumn& two = loops.columns[at(stops[r].first_column + j)];
            double sum = 0;
            for (int d = 0; d < nv; ++d) sum += one.k[d] * two.y[d];
            loops.A[at(row) * m + at(other)] += sum;
          }
        }
  });
}

// A diagonally pivoted Cholesky factorisation of the scaled matrix, which stops where what is left is negligible.
void choose_rows(LoopWorkspace& loops, double tolerance) noexcept {
  const std::size_t m = loops.rows.size();
  double* const F = loops.factor.data();
  std::vector<int>& order = loops.order;
  for (std::size_t i = 0; i < m; ++i) order[i] = static_cast<int>(i);
  for (std::size_t i = 0; i < m; ++i)
    for (std::size_t j = 0; j <= i; ++j) F[i * m + j] = loops.A[i * m + j] / std::sqrt(loops.rows[i].scale * loops.rows[j].scale);
  const auto element = [&](std::size_t i, std::size_t j) -> double& {  // of the remaining matrix, by original numbers
    const auto a = at(order[i]), b = at(order[j]);
    return a >= b ? F[a * m + b] : F[b * m + a];
  };
  loops.chosen.clear();
  for (std::size_t k = 0; k < m; ++k) {
    std::size_t best = k;
    for (std::size_t i = k + 1; i < m; ++i)
      if (element(i, i) > element(best, best)) best = i;
    const double pivot = element(best, best);
    if (!(pivot > tolerance)) break;
    std::swap(order[k], order[best]);
    loops.chosen.push_back(order[k]);
    for (std::size_t i = k + 1; i < m; ++i) {
      const double f = element(i, k) / pivot;
      if (f == 0) continue;
      for (std::size_t j = k + 1; j <= i; ++j) element(i, j) -= f * element(j, k);
    }
  }
  std::sort(loops.chosen.begin(), loops.chosen.end());
  loops.rank = static_cast<int>(loops.chosen.size());
}

void factorise_loops(LoopWorkspace& loops) noexcept {
  const std::size_t n = loops.chosen.size(), m = loops.rows.size();
  double* const L = loops.factor.data();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double s = loops.A[at(loops.chosen[i]) * m + at(loops.chosen[j])];
      for (std::size_t k = 0; k < j; ++k) s -= L[i * n + k] * L[j * n + k];
      L[i * n + j] = i == j ? std::sqrt(s) : s / L[j * n + j];
    }
}

void apply_multipliers(const Tree& tree, const double* q, Workspace<double>& workspace) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  const auto stops = tree.loop_stops();
  each_body_inward(stops, [&](std::size_t first, std::size_t end) {
    const int b = stops[first].body;
    Force<double> reduced{};
    double du[6] = {};
    const int nv = info(tree.kind(b)).nv;
    for (std::size_t s = first; s < end; ++s) {
      const LoopLink& link = tree.loop_links()[at(stops[s].loop)];
      for (int i = 0; i < link.rows; ++i) {
        const double lambda = loops.lambda[at(link.first_row + i)];
        if (lambda == 0) continue;
        const LoopColumn& column = loops.columns[at(stops[s].first_column + i)];
        reduced += lambda * column.K;
        for (int d = 0; d < nv; ++d) du[d] += lambda * column.y[d];
      }
    }
    Force<double>& W = workspace.reduced_bias_wrenches[at(b)];
    W = W - reduced;
    dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (!K::rigid)
        add_base_velocity(workspace.record<K>(tree, b), du,
                          K::template columns<double>(tree.link(b), joint_state(tree, q, workspace, b)));
    });
  });
}

void LoopCorrection::evaluate(const double* q, const double* u, double tolerance) noexcept {
  sweep_velocities<double, true>(tree, q, u, workspace);
  for (const int b : tree.order()) workspace.biases[at(b)] = {};
  std::fill_n(workspace.a.get(), tree.nv(), 0.0);
  reduce_accelerations<double, true>(tree, q, workspace);
  place_loops(tree, q, workspace, true);
  gather_loops(tree, q, workspace, {}, true);
  scale_rows(tree, workspace);
  choose_rows(*workspace.loops, tolerance > 0 ? tolerance : rank_tolerance);
  factorise_loops(*workspace.loops);
}

void LoopCorrection::finish(const double* q) noexcept {
  apply_multipliers(tree, q, workspace);
  resolve_accelerations<double, true>(tree, q, workspace, {});
}

}  // namespace detail

void solve_loops(const Tree& tree, const double* q, Workspace<double>& workspace, const Motion<double>& base, LoopRows rows,
                 bool velocities) noexcept {
  LoopWorkspace& loops = *workspace.loops;  // placed with the forces
  const bool choose = rows == LoopRows::choose || loops.rank < 0;
  detail::gather_loops(tree, q, workspace, base, choose);
  if (choose) {
    detail::scale_rows(tree, workspace);
    detail::choose_rows(loops, rank_tolerance);
  }
  detail::factorise_loops(loops);
  detail::solve_chosen(loops, [&](std::size_t row) { return -loops.b[row] - (velocities ? 0.0 : loops.rows[row].drift); });
  detail::apply_multipliers(tree, q, workspace);
  loops.impulsive = velocities;
  loops.least = false;
}

void solve_with_loops(const Tree& tree, const double* q, Workspace<double>& workspace, double* u) noexcept {
  for (const int b : tree.order()) workspace.biases[at(b)] = {};
  std::copy_n(u, tree.nv(), workspace.a.get());
  reduce_accelerations<double, true>(tree, q, workspace);
  solve_loops(tree, q, workspace, {}, LoopRows::choose, true);
  resolve_accelerations<double, true>(tree, q, workspace, {});
  std::copy_n(workspace.a.get(), tree.nv(), u);
}

void scale_multipliers(Workspace<double>& workspace, double factor) noexcept {
  for (double& lambda : workspace.loops->lambda) lambda *= factor;
}

void copy_chosen_rows(const Tree& tree, const Workspace<double>& from, Workspace<double>& to) noexcept {
  if (!tree.has_loops()) return;
  LoopWorkspace& loops = detail::loop_memory(tree, to);
  loops.chosen = from.loops->chosen, loops.turns = from.loops->turns;
  loops.rank = from.loops->rank;
}

}  // namespace momentree
