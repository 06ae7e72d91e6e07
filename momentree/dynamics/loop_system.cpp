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

template <class K>
constexpr int dofs_of = static_cast<int>(
    std::tuple_size_v<decltype(K::template columns<double>(std::declval<LinkConstants>(), std::declval<JointState<double>>()))>);

// The rows of one loop that take part.
struct Rows {
  int first, last;
  int count() const { return last - first; }
};
Rows rows_of(const LoopLayout& layout, int loop) { return {layout.first_of[at(loop)], layout.first_of[at(loop) + 1]}; }

// The unit wrenches of the rows on the bodies that their loops join.
void put_unit_wrenches(const Tree& tree, Workspace<double>& workspace, const LoopLayout& layout) {
  LoopWorkspace& loops = *workspace.loops;
  for (const LoopStop& stop : tree.loop_stops()) {
    const LoopLink& link = tree.loop_links()[at(stop.loop)];
    if (link.ends.coupling >= 0) {
      LoopColumn& column = loops.columns[at(stop.first_column)];
      column.K = {};
      column.effort = (stop.body == link.ends.joint ? 1.0 : 0.0) -
                      (stop.body == link.ends.follows ? loops.rows[at(link.first_row)].slope : 0.0);
      continue;
    }
    const Loop& loop = tree.loops()[at(stop.loop)];
    const LoopPlace& place = loops.places[at(stop.loop)];
    const Rows rows = rows_of(layout, stop.loop);
    LoopColumn* column = loops.columns.data() + stop.first_column;
    if (stop.body == loop.body || stop.body == loop.to) {
      const Kinematics<double>& body = workspace.bodies[at(stop.body)];
      const double sign = stop.body == loop.body ? 1 : -1;
      for (int r = rows.first; r < rows.last; ++r, ++column) {
        const LoopRow& row = loops.rows[at(layout.rows[at(r)])];
        column->K = sign * on_body(body, row.F, row.T, place.xb);
      }
    } else {
      for (int r = rows.first; r < rows.last; ++r, ++column) column->K = {};
    }
  }
}

// At one body: k and y of its columns, their part of b, and K handed on to the parent.
template <class K>
void reduce_columns(const Tree& tree, const double* q, Workspace<double>& workspace, const LoopLayout& layout, std::size_t first,
                    std::size_t end, const Motion<double>& base) {
  LoopWorkspace& loops = *workspace.loops;
  const auto stops = tree.loop_stops();
  const int b = stops[first].body;
  const LinkConstants& link = tree.link(b);
  const JointState<double> joint = joint_state(tree, q, workspace, b);
  [[maybe_unused]] const auto& record = workspace.record<K>(tree, b);
  [[maybe_unused]] double u0[6] = {};
  [[maybe_unused]] const auto E = K::template columns<double>(link, joint);
  if constexpr (!K::rigid) read_base_velocity<K>(record, u0);
  const Motion<double>& bias = workspace.biases[at(b)].acceleration;
  const auto each_column = [&](const auto& move_inboard) MOMENTREE_INLINE_LAMBDA {
    for (std::size_t s = first; s < end; ++s) {
      const LoopStop& stop = stops[s];
      const Rows rows = rows_of(layout, stop.loop);
      LoopColumn* column = loops.columns.data() + stop.first_column;
      LoopColumn* inboard = stop.inboard >= 0 ? loops.columns.data() + stops[at(stop.inboard)].first_column : nullptr;
      for (int r = rows.first; r < rows.last; ++r, ++column) {
        double& free = loops.b[at(layout.rows[at(r)])];
        Force<double> W = column->K;
        if constexpr (!K::rigid) {
          double effort[6] = {column->effort};
          for (std::size_t d = 0; d < E.size(); ++d) {
            const double along = dot(E[d], W) + effort[d];
            column->k[d] = (link.locked >> d & 1u) == 0 ? along : 0.0;
            free += column->k[d] * u0[d];
            if ((link.driven >> d & 1u) != 0) free += along * u0[d];
          }
          effort[0] = (link.locked & 1u) == 0 ? -column->effort : 0.0;
          K::template reduce_wrench<double>(link, joint, record, effort, W, column->y);
          for (std::size_t d = 0; d < E.size(); ++d) column->y[d] = -column->y[d];
          column->K = W;
          free += dot(bias, W);
          move_inboard(W);
        }
        if (inboard != nullptr)
          (inboard++)->K += W;
        else
          free += dot(base, W);
      }
    }
  };
  if constexpr (K::rigid)
    each_column([](Force<double>&) {});
  else
    wrenches_inboard<K>(link, joint, record, tree.node_flags()[at(tree.place(b))], each_column);
}

// A += kᵀ y of the columns at one body.
template <int NV>
void add_products(LoopWorkspace& loops, std::span<const LoopStop> at_body, const LoopLayout& layout) {
  for (std::size_t s = 0; s < at_body.size(); ++s) {
    const Rows rows = rows_of(layout, at_body[s].loop);
    for (std::size_t t = 0; t <= s; ++t) {
      const Rows others = rows_of(layout, at_body[t].loop);
      const LoopColumn* one = loops.columns.data() + at_body[s].first_column;
      for (int i = rows.first; i < rows.last; ++i, ++one) {
        double* const A = loops.A.data() + layout.position[at(i)];
        const LoopColumn* two = loops.columns.data() + at_body[t].first_column;
        for (int j = others.first; j < std::min(others.last, i + 1); ++j, ++two) {
          double sum = 0;
          for (int d = 0; d < NV; ++d) sum += one->k[d] * two->y[d];
          A[j] += sum;
        }
      }
    }
  }
}

}  // namespace

namespace detail {

void gather_loops(const Tree& tree, const double* q, Workspace<double>& workspace, const Motion<double>& base,
                  bool all) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  const LoopLayout& layout = all ? loops.all : loops.kept;
  const auto stops = tree.loop_stops();
  loops.whole = all;
  std::fill_n(loops.A.begin(), layout.elements, 0.0);
  std::fill_n(loops.b.begin(), loops.rows.size(), 0.0);
  put_unit_wrenches(tree, workspace, layout);
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {  // the ground's ends
    if (tree.loops()[i].to >= 0) continue;
    const Rows rows = rows_of(layout, static_cast<int>(i));
    for (int r = rows.first; r < rows.last; ++r) {
      const auto row = at(layout.rows[at(r)]);
      loops.b[row] -= dot(loops.rows[row].F, base.v);
    }
  }
  each_body_inward(stops, [&](std::size_t first, std::size_t end) {
    const int b = stops[first].body;
    dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      reduce_columns<K>(tree, q, workspace, layout, first, end, base);
      if constexpr (dofs_of < K >> 0) add_products<dofs_of<K>>(loops, stops.subspan(first, end - first), layout);
    });
  });
}

// Between states a mechanism may pass a singular position, where the multiplier of a row that is independent at the start of the
// step would grow beyond all bounds: there the row is left out, by an infinite element on the diagonal.
void factorise_loops(LoopWorkspace& loops) noexcept {
  constexpr double small = 1e-6, share = 0.1;  // of the row's scale, and of its pivot where rows were chosen
  const LoopLayout& kept = loops.kept;
  double* const L = loops.factor.data();
  const auto n = static_cast<std::ptrdiff_t>(kept.rows.size());
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const auto row = static_cast<std::size_t>(i);
    double* const own = L + kept.position[row];
    const double* const A = loops.A.data() + kept.position[row];
    const std::ptrdiff_t from = kept.begin[row];
    for (std::ptrdiff_t j = from; j <= i; ++j) {
      const auto column = static_cast<std::size_t>(j);
      const double* const other = L + kept.position[column];
      double s = loops.whole ? loops.all.element(loops.A, at(kept.rows[row]), at(kept.rows[column])) : A[j];
      for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(from, kept.begin[column]); k < j; ++k) s -= own[k] * other[k];
      own[j] = j < i ? s / other[j] : s;
    }
    double& least = loops.least_pivots[row];
    if (loops.whole) least = std::min(small * loops.rows[at(kept.rows[row])].scale, share * own[i]);
    own[i] = own[i] > least ? std::sqrt(own[i]) : HUGE_VAL;
  }
}

void apply_multipliers(const Tree& tree, const double* q, Workspace<double>& workspace) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  const LoopLayout& layout = loops.whole ? loops.all : loops.kept;
  const auto stops = tree.loop_stops();
  each_body_inward(stops, [&](std::size_t first, std::size_t end) {
    const int b = stops[first].body;
    dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      Force<double> reduced{};
      double du[6] = {};
      for (std::size_t s = first; s < end; ++s) {
        const Rows rows = rows_of(layout, stops[s].loop);
        const LoopColumn* column = loops.columns.data() + stops[s].first_column;
        for (int r = rows.first; r < rows.last; ++r, ++column) {
          const double lambda = loops.lambda[at(layout.rows[at(r)])];
          reduced += lambda * column->K;
          for (int d = 0; d < dofs_of<K>; ++d) du[d] += lambda * column->y[d];
        }
      }
      Force<double>& W = workspace.reduced_bias_wrenches[at(b)];
      W = W - reduced;
      if constexpr (!K::rigid)
        add_base_velocity(workspace.record<K>(tree, b), du,
                          K::template columns<double>(tree.link(b), joint_state(tree, q, workspace, b)));
    });
  });
}

void LoopCorrection::gather(const double* q, const double* u) noexcept {
  sweep_velocities<double, true>(tree, q, u, workspace);
  for (const int b : tree.order()) workspace.biases[at(b)] = {};
  std::fill_n(workspace.a.get(), tree.nv(), 0.0);
  reduce_accelerations<double, true>(tree, q, workspace);
  place_loops(tree, q, workspace, true);
  gather_loops(tree, q, workspace, {}, true);
  soften(*workspace.loops);
}

void LoopCorrection::evaluate(const double* q, const double* u, double tolerance) noexcept {
  gather(q, u);
  scale_rows(tree, workspace);
  choose_rows(tree, *workspace.loops, tolerance > 0 ? tolerance : rank_tolerance);
  factorise_loops(*workspace.loops);
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
  factorise_loops(loops);
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
  if (tree.loop_armatures() > 0) detail::soften(loops);
  if (choose) {
    detail::scale_rows(tree, workspace);
    detail::choose_rows(tree, loops, rank_tolerance);
  }
  detail::factorise_loops(loops);
  detail::solve_chosen(
      loops, [&](std::size_t row) { return -loops.b[row] + (velocities ? loops.rows[row].jump_to : -loops.rows[row].drift); });
  detail::apply_multipliers(tree, q, workspace);
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

void copy_chosen_rows(const Tree& tree, const Workspace<double>& from, Workspace<double>& to) noexcept {
  if (!tree.has_loops()) return;
  LoopWorkspace& loops = detail::loop_memory(tree, to);
  loops.kept = from.loops->kept, loops.least_pivots = from.loops->least_pivots, loops.turns = from.loops->turns;
  loops.rank = from.loops->rank;
}

}  // namespace momentree
