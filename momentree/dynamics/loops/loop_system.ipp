#pragma once
// The system of the loops' rows for any scalar: A = J M⁻¹ Jᵀ and b from the records of the inward pass, its solution, and what
// this adds to the records. Included only by loop_kernels.cpp and by instantiate/*.cpp of other scalars.
#include <algorithm>
#include <cmath>
#include <tuple>

#include <momentree/dynamics/loops/loop_kernels.hpp>
#include <momentree/dynamics/wrench_inboard.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/joint_mass.hpp>
#include <momentree/math/lanes.hpp>

namespace momentree::detail {

MOMENTREE_INLINE std::size_t at(int i) { return static_cast<std::size_t>(i); }

template <class T, class Record>
MOMENTREE_INLINE void add_base_velocity(Record& record, const T* du, const auto& E) {
  if constexpr (requires { record.a0; }) {
    for (std::size_t i = 0; i < E.size(); ++i) record.a0 = record.a0 + Motion<T>{du[i] * E[i].v, du[i] * E[i].w};
  } else {
    for (std::size_t i = 0; i < E.size(); ++i) record.u0[i] += du[i];
  }
}

// Calls f(first stop, end of the stops of its body) for all bodies with stops, outboard before inboard.
template <class F>
MOMENTREE_INLINE void each_body_inward(std::span<const LoopStop> stops, const F& f) {
  for (std::size_t end = stops.size(); end > 0;) {
    std::size_t first = end - 1;
    while (first > 0 && stops[first - 1].body == stops[end - 1].body) --first;
    f(first, end);
    end = first;
  }
}

template <class K>
constexpr int dofs_of_kernels = static_cast<int>(
    std::tuple_size_v<decltype(K::template columns<double>(std::declval<LinkConstants>(), std::declval<JointState<double>>()))>);

// The rows of one loop that take part.
struct RowRange {
  int first, last;
};
MOMENTREE_INLINE RowRange rows_of(const LoopLayout& layout, int loop) {
  return {layout.first_of[at(loop)], layout.first_of[at(loop) + 1]};
}

// The unit wrenches of the rows on the bodies that their loops join.
template <class T>
[[gnu::flatten]] void put_unit_wrenches(const Tree& tree, const Workspace<T>& workspace, LoopSystem<T>& loops,
                                        const LoopLayout& layout) {
  for (const LoopStop& stop : tree.loops().stops) {
    const LoopLink& link = tree.loops().links[at(stop.loop)];
    LoopColumnOf<T>* column = loops.columns.data() + stop.first_column;
    if (link.ends.coupling >= 0) {
      column->K = {};
      column->effort = T(stop.body == link.ends.joint ? 1.0 : 0.0);
      if (stop.body == link.ends.follows) column->effort -= loops.rows[at(link.first_row)].slope;
      continue;
    }
    const Loop& loop = tree.loops()[at(stop.loop)];
    const LoopPlaceOf<T>& place = loops.places[at(stop.loop)];
    const RowRange rows = rows_of(layout, stop.loop);
    if (stop.body == loop.body || stop.body == loop.to) {
      const Kinematics<T>& body = workspace.bodies[at(stop.body)];
      const double sign = stop.body == loop.body ? 1 : -1;
      for (int r = rows.first; r < rows.last; ++r, ++column) {
        const LoopRowOf<T>& row = loops.rows[at(layout.rows[at(r)])];
        column->K = sign * on_body(body, row.F, row.T, place.xb);
      }
    } else {
      for (int r = rows.first; r < rows.last; ++r, ++column) column->K = {};
    }
  }
}

// At one body: k and y of its columns, their part of b, and K handed on to the parent.
template <class K, class T>
void reduce_columns(const Tree& tree, const T* q, Workspace<T>& workspace, LoopSystem<T>& loops, const LoopLayout& layout,
                    std::size_t first, std::size_t end, const Motion<T>& base) {
  const std::span<const LoopStop> stops = tree.loops().stops;
  const UncheckedTree all(tree);
  const int b = stops[first].body;
  const LinkConstants& link = all.link(b);
  const JointState<T> joint = joint_state(all, q, workspace, b);
  [[maybe_unused]] const auto& record = workspace.template record<K>(all, b);
  [[maybe_unused]] T u0[6] = {};
  [[maybe_unused]] const auto E = K::template columns<T>(link, joint);
  if constexpr (!K::rigid) K::joint_velocity(record, Motion<T>{}, u0);
  const Motion<T>& bias = workspace.biases[at(b)].acceleration;
  const auto each_column = [&](const auto& move_inboard) MOMENTREE_INLINE_LAMBDA {
    for (std::size_t s = first; s < end; ++s) {
      const LoopStop& stop = stops[s];
      const RowRange rows = rows_of(layout, stop.loop);
      LoopColumnOf<T>* column = loops.columns.data() + stop.first_column;
      LoopColumnOf<T>* inboard = stop.inboard >= 0 ? loops.columns.data() + stops[at(stop.inboard)].first_column : nullptr;
      for (int r = rows.first; r < rows.last; ++r, ++column) {
        T& free = loops.b[at(layout.rows[at(r)])];
        Force<T> W = column->K;
        if constexpr (!K::rigid) {
          T effort[6] = {column->effort};
          for (std::size_t d = 0; d < E.size(); ++d) {
            const T along = dot(E[d], W) + effort[d];
            column->k[d] = (link.locked >> d & 1u) == 0 ? along : T(0);
            free += column->k[d] * u0[d];
            if ((link.driven >> d & 1u) != 0) free += along * u0[d];
          }
          effort[0] = (link.locked & 1u) == 0 ? -column->effort : T(0);
          K::template reduce_wrench<T>(link, joint, record, effort, W, column->y);
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
    each_column([](Force<T>&) {});
  else
    wrenches_inboard<K>(link, joint, record, tree.tables().node_flags[at(tree.place(b))], each_column);
}

// A += kᵀ y of the columns at one body.
template <int NV, class T>
void add_products(LoopSystem<T>& loops, std::span<const LoopStop> at_body, const LoopLayout& layout) {
  for (std::size_t s = 0; s < at_body.size(); ++s) {
    const RowRange rows = rows_of(layout, at_body[s].loop);
    for (std::size_t t = 0; t <= s; ++t) {
      const RowRange others = rows_of(layout, at_body[t].loop);
      const LoopColumnOf<T>* one = loops.columns.data() + at_body[s].first_column;
      for (int i = rows.first; i < rows.last; ++i, ++one) {
        T* const A = loops.A.data() + layout.position[at(i)];
        const LoopColumnOf<T>* two = loops.columns.data() + at_body[t].first_column;
        const int last = others.last < i + 1 ? others.last : i + 1;
        for (int j = others.first; j < last; ++j, ++two) {
          T sum(0);
          for (int d = 0; d < NV; ++d) sum += one->k[d] * two->y[d];
          A[j] += sum;
        }
      }
    }
  }
}

template <class T>
void gather_loops(const Tree& tree, const T* q, Workspace<T>& workspace, LoopSystem<T>& loops, const Motion<T>& base,
                  bool all) noexcept {
  const LoopLayout& layout = all ? loops.all : loops.kept;
  const std::span<const LoopStop> stops = tree.loops().stops;
  loops.whole = all;
  for (std::size_t i = 0; i < layout.elements; ++i) loops.A[i] = T(0);
  for (std::size_t i = 0; i < loops.rows.size(); ++i) loops.b[i] = T(0);
  put_unit_wrenches(tree, workspace, loops, layout);
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {  // the ground's ends
    if (tree.loops()[i].to >= 0) continue;
    const RowRange rows = rows_of(layout, static_cast<int>(i));
    for (int r = rows.first; r < rows.last; ++r) {
      const auto row = at(layout.rows[at(r)]);
      loops.b[row] -= dot(loops.rows[row].F, base.v);
    }
  }
  each_body_inward(stops, [&](std::size_t first, std::size_t end) {
    const int b = stops[first].body;
    dispatch_kernels(UncheckedTree(tree).kind(b), UncheckedTree(tree).variant(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      reduce_columns<K, T>(tree, q, workspace, loops, layout, first, end, base);
      if constexpr (dofs_of_kernels < K >> 0)
        add_products<dofs_of_kernels<K>, T>(loops, stops.subspan(first, end - first), layout);
    });
  });
}

template <class T>
void soften(LoopSystem<T>& loops) noexcept {
  const LoopLayout& layout = loops.whole ? loops.all : loops.kept;
  for (std::size_t i = 0; i < layout.rows.size(); ++i)
    loops.A[static_cast<std::size_t>(layout.position[i] + static_cast<std::ptrdiff_t>(i))] +=
        loops.rows[at(layout.rows[i])].softness;
}

// Between states a mechanism may pass a singular position, where the multiplier of a row that is independent at the start of the
// step would grow beyond all bounds: there the row is left out, by an infinite element on the diagonal.
template <class T>
MOMENTREE_INLINE void take_pivot(bool whole, const T& scale, T& least, T& pivot) {
  constexpr double small = 1e-6, share = 0.1;  // of the row's scale, and of its pivot where rows were chosen
  for (int l = 0; l < lanes_of<T>; ++l) {
    const double d = get_lane(pivot, l), first = small * get_lane(scale, l), second = share * d;
    double limit = get_lane(least, l);
    if (whole && limit != HUGE_VAL) set_lane(least, l, limit = second < first ? second : first);
    set_lane(pivot, l, d > limit ? std::sqrt(d) : HUGE_VAL);
  }
}

template <class T>
void factorise_loops(LoopSystem<T>& loops) noexcept {
  const LoopLayout& kept = loops.kept;
  T* const L = loops.factor.data();
  const auto n = static_cast<std::ptrdiff_t>(kept.rows.size());
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const auto row = static_cast<std::size_t>(i);
    T* const own = L + kept.position[row];
    const T* const A = loops.A.data() + kept.position[row];
    const std::ptrdiff_t from = kept.begin[row];
    for (std::ptrdiff_t j = from; j <= i; ++j) {
      const auto column = static_cast<std::size_t>(j);
      const T* const other = L + kept.position[column];
      T s = loops.whole ? loops.all.element(loops.A, at(kept.rows[row]), at(kept.rows[column])) : A[j];
      const std::ptrdiff_t both = from > kept.begin[column] ? from : kept.begin[column];
      for (std::ptrdiff_t k = both; k < j; ++k) s -= own[k] * other[k];
      own[j] = j < i ? s / other[j] : s;
    }
    take_pivot(loops.whole, loops.rows[at(kept.rows[row])].scale, loops.least_pivots[row], own[i]);
  }
}

template <class T>
void apply_multipliers(const Tree& tree, const T* q, Workspace<T>& workspace, LoopSystem<T>& loops) noexcept {
  const LoopLayout& layout = loops.whole ? loops.all : loops.kept;
  const std::span<const LoopStop> stops = tree.loops().stops;
  const UncheckedTree all(tree);
  each_body_inward(stops, [&](std::size_t first, std::size_t end) {
    const int b = stops[first].body;
    dispatch_kernels(UncheckedTree(tree).kind(b), UncheckedTree(tree).variant(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      Force<T> reduced{};
      T du[6] = {};
      for (std::size_t s = first; s < end; ++s) {
        const RowRange rows = rows_of(layout, stops[s].loop);
        const LoopColumnOf<T>* column = loops.columns.data() + stops[s].first_column;
        for (int r = rows.first; r < rows.last; ++r, ++column) {
          const T lambda = loops.lambda[at(layout.rows[at(r)])];
          reduced += lambda * column->K;
          for (int d = 0; d < dofs_of_kernels<K>; ++d) du[d] += lambda * column->y[d];
        }
      }
      Force<T>& W = workspace.reduced_bias_wrenches[at(b)];
      W = W - reduced;
      if constexpr (!K::rigid)
        add_base_velocity(workspace.template record<K>(all, b), du,
                          K::template columns<T>(all.link(b), joint_state(all, q, workspace, b)));
    });
  });
}

// wᵀ M⁻¹ w for a wrench on a free body of a loop of that extent (m): what the row's element of A is at most. 1 for a body without
// mass. A point mass gets an inertia that is small for the loop: the joints determine how it turns.
template <class T>
MOMENTREE_INLINE T wrench_mobility(const RigidMass& body, const Force<T>& w, double extent) {
  if (!(body.m > 0)) return T(1);
  const Vec3 c = (1 / body.m) * body.mc;
  const Vector3<T> t = w.h - cross(c, w.l);
  JointMass<double, 3> J;
  const auto& O = body.J;
  const double cc = dot(c, c), m = body.m;
  const double xx = O.xx - m * (cc - c.x * c.x), yy = O.yy - m * (cc - c.y * c.y), zz = O.zz - m * (cc - c.z * c.z);
  // Rods and points have no inertia about some axes.
  const double least = 1e-6 * (xx + yy + zz) + 1e-6 * m * extent * extent + 1e-300;
  J(0, 0) = least + xx, J(1, 1) = least + yy, J(2, 2) = least + zz;
  J(1, 0) = O.xy + m * c.x * c.y, J(2, 0) = O.xz + m * c.x * c.z, J(2, 1) = O.yz + m * c.y * c.z;
  J.factorise();
  T a[3] = {t.x, t.y, t.z};
  J.solve(a);
  T s = dot(w.l, w.l) / m + t.x * a[0] + t.y * a[1] + t.z * a[2];
  for (int l = 0; l < lanes_of<T>; ++l)
    if (const double x = get_lane(s, l); !(x > 0 && x < HUGE_VAL)) set_lane(s, l, 1);
  return s;
}

template <class T>
void scale_rows(const Tree& tree, const Workspace<T>& workspace, LoopSystem<T>& loops) noexcept {
  constexpr double stiffest_armature = 1e6;  // a soft row is never redundant, however large the armature is beside the bodies
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    const LoopLink& link = tree.loops().links[i];
    for (int k = 0; k < link.rows; ++k) {
      LoopRowOf<T>& row = loops.rows[at(link.first_row + k)];
      const auto at_body = [&](int b) MOMENTREE_INLINE_LAMBDA {
        return wrench_mobility(tree.link(b).body, on_body(workspace.bodies[at(b)], row.F, row.T, loops.places[i].xb),
                               loops.extents[i]);
      };
      row.scale = at_body(loop.body);
      if (loop.to >= 0) row.scale += at_body(loop.to);
      for (int l = 0; l < lanes_of<T>; ++l) {
        const double softness = get_lane(row.softness, l), scale = get_lane(row.scale, l) + softness;
        const double most = stiffest_armature * softness;
        set_lane(row.scale, l, softness > 0 && most < scale ? most : scale);
      }
    }
  }
  // The element of A of a coupling's row is a sum of squares without cancellation; it is zero if both joints are locked.
  for (std::size_t i = tree.loops().size(); i < tree.loops().links.size(); ++i) {
    const auto row = at(tree.loops().links[i].first_row);
    T own = loops.all.element(loops.A, row, row);
    for (int l = 0; l < lanes_of<T>; ++l)
      if (const double x = get_lane(own, l); !(x > 0 && x < HUGE_VAL)) set_lane(own, l, 1);
    loops.rows[row].scale = own;
  }
}

}  // namespace momentree::detail
