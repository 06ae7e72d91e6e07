#pragma once
// The steps of loops for any scalar; see loop_system.hpp for what they do. Packs compute several worlds of one topology, each
// with the rows that were chosen for it.
#include <cmath>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/math/lanes.hpp>

namespace momentree {

/// A force and a torque at the point x, world axes, as a wrench on a body in its kernel frame.
template <class T>
MOMENTREE_INLINE Force<T> on_body(const Kinematics<T>& body, const Vector3<T>& force, const Vector3<T>& torque,
                                  const Vector3<T>& x) {
  return {transpose_times(body.R, force), transpose_times(body.R, torque + cross(x - body.r, force))};
}

}  // namespace momentree

namespace momentree::detail {

/// Rows are independent if their pivots in the scaled A are larger; those of redundant rows are below 1e-15.
inline constexpr double rank_tolerance = 1e-9;
/// Loops that are open by this much are as good as closed where redundant rows contradict each other: axes of CAD files have such
/// errors.
inline constexpr double nearly_closed = 1e-7;

/// Loops are closed: |φ| relative to the size of the loop, and as a sine of angles.
inline constexpr double closed = 1e-14;
inline constexpr int most_corrections = 8;

/// Calls f(lane) for the lanes in use.
template <class T, class F>
MOMENTREE_INLINE void each_lane(const LoopConstants& loops, const F& f) {
  for (int l = 0; l < lanes_of<T>; ++l)
    if (lanes_of<T> == 1 || (loops.lanes >> l & 1u) != 0) f(l);
}

/// Lays out the memory for the tree's present topology.
void lay_out_constants(const Tree& tree, int lanes, LoopConstants& to);
template <class T>
void lay_out_loops(const Tree& tree, LoopSystem<T>& loops) {
  const auto rows = static_cast<std::size_t>(tree.loops().rows);
  lay_out_constants(tree, lanes_of<T>, loops);
  loops.places.resize(tree.loops().size());
  loops.rows.assign(rows, LoopRowOf<T>{});
  loops.columns.assign(static_cast<std::size_t>(tree.loops().columns), LoopColumnOf<T>{});
  loops.A.resize(loops.all.elements), loops.factor.resize(loops.all.elements), loops.least_pivots.resize(rows);
  loops.b.resize(2 * rows), loops.lambda.resize(rows);
  loops.sizes.resize(tree.loops().links.size() - tree.loops().size());
}

/// Poses, velocities, places and rows of closures; not of single DoFs and couplings.
template <class T>
void place_closures(const Tree& tree, const T* q, Workspace<T>& workspace, LoopSystem<T>& loops, bool moving,
                    LoopRows which) noexcept;
/// The rows of single DoFs, and of couplings, lane by lane.
template <class T>
void place_other_rows(const Tree& tree, const T* q, const Workspace<T>& workspace, LoopSystem<T>& loops, bool moving) noexcept;
template <class T>
void soften(LoopSystem<T>& loops) noexcept;
template <class T>
void scale_rows(const Tree& tree, const Workspace<T>& workspace, LoopSystem<T>& loops) noexcept;
template <class T>
void gather_loops(const Tree& tree, const T* q, Workspace<T>& workspace, LoopSystem<T>& loops, const Motion<T>& base,
                  bool all) noexcept;
template <class T>
void factorise_loops(LoopSystem<T>& loops) noexcept;
template <class T>
void apply_multipliers(const Tree& tree, const T* q, Workspace<T>& workspace, LoopSystem<T>& loops) noexcept;

/// Solves A λ = right(row) with the factor; λ of rows that are not kept is zero.
template <class T, class Right>
void solve_chosen(LoopSystem<T>& loops, Right right) noexcept {
  const LoopLayout& kept = loops.kept;
  const auto n = static_cast<std::ptrdiff_t>(kept.rows.size());
  for (T& lambda : loops.lambda) lambda = T(0);
  T* const x = loops.b.data() + loops.rows.size();  // scratch behind b
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const auto here = static_cast<std::size_t>(i);
    const T* const L = loops.factor.data() + kept.position[here];
    T s = right(static_cast<std::size_t>(kept.rows[here]));
    for (std::ptrdiff_t j = kept.begin[here]; j < i; ++j) s -= L[j] * x[j];
    x[i] = s / L[i];
  }
  for (std::ptrdiff_t i = n; i-- > 0;) {
    const auto here = static_cast<std::size_t>(i);
    const T* const L = loops.factor.data() + kept.position[here];
    x[i] = x[i] / L[i];
    for (std::ptrdiff_t j = kept.begin[here]; j < i; ++j) x[j] -= L[j] * x[i];
    loops.lambda[static_cast<std::size_t>(kept.rows[here])] = x[i];
  }
}

/// Forces in loop joints at times t, by lane; adds their power, by lane.
template <class T>
void add_loop_forces(const Tree& tree, const double* t, Workspace<T>& workspace, LoopSystem<T>& loops, Power* power,
                     const double* given = nullptr) noexcept;

// Computed in double, lane by lane, the same for all instruction sets.

/// The angle of a screw from 2 sin and 2 cos, nearest to `turn`.
double screw_angle(double si, double co, double turn) noexcept;
/// The row of a single DoF at a place with velocities. `motion`: its prescribed motion at present, if it has one.
LoopRow dof_row(const Tree& tree, int loop, const DofRow& of, const LoopPlace& place, const Turns& turns,
                const Curve::Point& motion) noexcept;
/// The row of a DoF on the relative motion of a loop joint's frames, in the axes of its own child-side frame, at coordinates q.
Motion<double> dof_direction(const JointSpec& joint, const double* q, int dof) noexcept;
/// True if a loop joint exerts forces along its DoFs, other than those of a prescribed motion.
bool has_forces(const Loop& loop) noexcept;
/// A coupling's value at x and its derivatives there, and the size of its terms, for tolerances.
struct CouplingPoint {
  double value, slope, curvature, size;
};
CouplingPoint coupling_point(const Tree& tree, int coupling, double x) noexcept;
/// True if the joint's coordinate is a length.
bool is_length(const Tree& tree, int body) noexcept;
/// True if the residual of a row of a loop, given by its place among those of the loop, is a length.
bool is_length(const Tree& tree, std::size_t link, int row) noexcept;
/// Sets prescribed motions of loop joints to times t (s), by lane.
void set_loop_motions(const Tree& tree, const double* t, int lanes, LoopConstants& loops) noexcept;
/// Coordinates and velocities of a loop joint whose frames are at `p`; its angle is nearest to `turns`.
void loop_coordinates_at(const Tree& tree, int place, const LoopPlace& p, const Turns& turns, double* q, double* u) noexcept;
Turns turns_at(const Tree& tree, int place, const LoopPlace& p, const Turns& hint) noexcept;
/// loop_joint_wrench at a place. `given`: efforts of the joint's function by DoF; null: none.
Force<double> joint_wrench_at(const Tree& tree, double t, int place, const LoopPlace& p, const Turns& turns, const double* given,
                              double* effort, Power& power) noexcept;
/// The same wrench in world axes, about xb; adds its power.
Force<double> loop_force(const Tree& tree, double t, int place, const LoopPlace& p, const Turns& turns, const double* given,
                         Power& power) noexcept;

/// By what residuals of a row are measured, given by its place among those of its link: the size of a loop (m), or 1 for
/// directions.
template <class T>
double row_size(const Tree& tree, const LoopSystem<T>& loops, std::size_t link, int row, int lane = 0) noexcept {
  const LoopLink& own = tree.loops().links[link];
  const std::size_t loop_count = tree.loops().size();
  if (own.ends.coupling < 0 && !is_length(tree, link, row)) return 1;
  const double size = get_lane(own.ends.coupling >= 0 ? loops.sizes[link - loop_count] : loops.places[link].size, lane);
  return size < 1e-300 ? 1e-300 : size;
}
/// The largest residual of a link relative to these sizes, in a lane; NaN if one is.
template <class T>
double open_by(const Tree& tree, const LoopSystem<T>& loops, std::size_t link, int lane = 0) noexcept {
  double worst = 0;
  const LoopLink& own = tree.loops().links[link];
  for (int i = 0; i < own.rows; ++i) {
    const double residual = get_lane(loops.rows[static_cast<std::size_t>(own.first_row + i)].residual, lane);
    const double size = row_size(tree, loops, link, i, lane);
    const double part = size < HUGE_VAL ? std::fabs(residual) / size : HUGE_VAL;  // lengths beyond all bounds
    if (!(part <= worst)) worst = part;                                           // NaN is kept
  }
  return worst;
}

/// That of all links.
template <class T>
double most_open(const Tree& tree, const LoopSystem<T>& loops, int lane = 0) noexcept {
  double worst = 0;
  for (std::size_t i = 0; i < tree.loops().links.size(); ++i)
    if (const double part = open_by(tree, loops, i, lane); !(part <= worst)) worst = part;
  return worst;
}

/// Chooses the rows of each lane as choose_rows does, and keeps those that any lane needs.
class LaneChoice {
 public:
  LaneChoice();
  ~LaneChoice();  // not of an instruction set
  /// Allocates if there are more rows than before.
  void fit(const Tree& tree);
  /// For all lanes.
  template <class T>
  void choose(const Tree& tree, LoopSystem<T>& loops) noexcept {
    start();
    each_lane<T>(loops, [&](int l) {
      for (std::size_t i = 0; i < loops.all.elements; ++i) A()[i] = get_lane(loops.A[i], l);
      for (std::size_t i = 0; i < loops.rows.size(); ++i) set_scale(i, get_lane(loops.rows[i].scale, l));
      choose_lane(tree, l);
    });
    keep(tree, loops.kept);
    for (std::size_t i = 0; i < loops.kept.rows.size(); ++i)
      for (int l = 0; l < lanes_of<T>; ++l) set_lane(loops.least_pivots[i], l, chosen(loops.kept.rows[i], l) ? 0.0 : HUGE_VAL);
  }

 private:
  double* A() noexcept;
  void set_scale(std::size_t row, double scale) noexcept;
  void start() noexcept;
  void choose_lane(const Tree& tree, int lane) noexcept;
  void keep(const Tree& tree, LoopLayout& kept) noexcept;
  bool chosen(int row, int lane) const noexcept;

  LoopWorkspace one_;             // of the lane at hand
  std::vector<unsigned> chosen_;  // by row, a bit for each lane
  std::vector<int> union_;
};

}  // namespace momentree::detail
