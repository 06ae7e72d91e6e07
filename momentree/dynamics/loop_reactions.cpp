// Reactions of loop joints, and which reactions the loops determine.
#include <algorithm>
#include <cmath>

#include <momentree/dynamics/loop_system.hpp>
#include <momentree/dynamics/wrench_inboard.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/motion.hpp>

namespace momentree {

namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

LoopImpulse loop_impulse(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  LoopImpulse found;
  const LoopWorkspace& loops = *workspace.loops;
  if (!loops.impulsive || loops.topology != tree.revision()) return found;
  const LoopLink& link = tree.loop_links()[at(place)];
  for (int i = 0; i < link.rows; ++i) {
    const auto row = at(link.first_row + i);
    found.force += loops.lambda[row] * loops.rows[row].F;
    found.torque += loops.lambda[row] * loops.rows[row].T;
  }
  found.at = loops.places[at(place)].xb;
  return found;
}

LoopReaction loop_reaction(const Tree& tree, double t, const Workspace<double>& workspace, int place) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  const LoopLink& link = tree.loop_links()[at(place)];
  const LoopWorkspace& loops = *workspace.loops;
  const LoopPlace& p = loops.places[at(place)];
  const Kinematics<double>& child = workspace.bodies[at(loop.body)];
  LoopReaction found;
  Vec3 F{}, T{};
  for (int i = 0; i < link.rows; ++i) {
    const auto row = at(link.first_row + i);
    F += loops.lambda[row] * loops.rows[row].F;
    T += loops.lambda[row] * loops.rows[row].T;
  }
  const Force<double> constraint = on_body(child, F, T, p.xb);
  const Force<double> W = loop_joint_wrench(tree, t, workspace, place, found.effort);
  const Mat3 Rb = p.Ra * p.R;
  const Force<double> along = on_body(child, Rb * W.l, Rb * W.h, p.xb);
  found.constraint = {constraint.l, constraint.h};
  found.total = {constraint.l + along.l, constraint.h + along.h};
  return found;
}

double loop_velocities_open(const Tree& tree, const Workspace<double>& workspace) noexcept {
  double worst = 0;
  if (tree.has_loops())
    for (const LoopRow& row : workspace.loops->rows) worst = std::max(worst, std::fabs(row.velocity));
  return worst;
}

// The nearest coordinates give the pose of the joint, unless directions are reversed.
bool loop_flipped(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  const LoopPlace& p = workspace.loops->places[at(place)];
  const JointSpec spec = spec_of(tree.loops()[at(place)].joint);
  double q[7] = {};
  nearest_coordinates(spec, {p.r, quaternion_of(p.R)}, workspace.loops->turns[at(place)], q);
  const Mat3 R = transpose(rotation_matrix(joint_motion(spec, q).rotation)) * p.R;
  return R.xx + R.yy + R.zz < 2.9;
}

namespace {

// The null space of the rows, one vector after the other, in lambda: multipliers that move nothing. Calls f() for each.
template <class F>
void each_null_vector(LoopWorkspace& loops, const F& f) {
  const std::size_t m = loops.rows.size();
  std::vector<double> kept = loops.lambda;
  for (std::size_t row = 0; row < m; ++row) {
    if (std::binary_search(loops.chosen.begin(), loops.chosen.end(), static_cast<int>(row))) continue;
    // Jᵀ of the dropped row is a combination of those of the chosen ones.
    detail::solve_chosen(loops, [&](std::size_t i) {
      return -(i >= row ? loops.A[i * m + row] : loops.A[row * m + i]);
    });
    loops.lambda[row] = 1;
    f();
  }
  loops.lambda = kept;
}

// Sum of the rows' wrenches on a loop's child, per unit of size.
double wrench_size(const LoopWorkspace& loops, const LoopLink& link, double size) {
  Vec3 F{}, T{};
  for (int i = 0; i < link.rows; ++i) {
    const auto row = at(link.first_row + i);
    F += loops.lambda[row] * loops.rows[row].F;
    T += loops.lambda[row] * loops.rows[row].T;
  }
  return norm(F) + norm(T) / std::max(size, 1e-300);
}

constexpr double undetermined_above = 1e-7;

}  // namespace

bool loop_determined(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  if (loops.rank == tree.loop_rows()) return true;
  bool determined = true;
  each_null_vector(loops, [&] {
    const double size = loops.places[at(place)].size;
    determined = determined && !(wrench_size(loops, tree.loop_links()[at(place)], size) > undetermined_above);
  });
  return determined;
}

// A null vector changes the wrench of a body's inboard joint by the sum of the loops' wrenches on the body and all outboard.
bool joint_determined(const Tree& tree, const Workspace<double>& workspace, int body) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  if (loops.rank == tree.loop_rows()) return true;
  bool determined = true;
  each_null_vector(loops, [&] {
    Vec3 F{}, T{};
    double size = 0;
    for (std::size_t i = 0; i < tree.loops().size(); ++i) {
      const Loop& loop = tree.loops()[i];
      const auto outboard = [&](int b) {
        while (b >= 0 && b != body) b = tree.parent(b);
        return b == body;
      };
      const int side = (outboard(loop.body) ? 1 : 0) - (loop.to >= 0 && outboard(loop.to) ? 1 : 0);
      if (side == 0) continue;
      const LoopLink& link = tree.loop_links()[i];
      const Vec3 x = loops.places[i].xb;
      size = std::max(size, loops.places[i].size);
      for (int k = 0; k < link.rows; ++k) {
        const auto row = at(link.first_row + k);
        const double l = side * loops.lambda[row];
        F += l * loops.rows[row].F;
        T += l * (loops.rows[row].T + cross(x, loops.rows[row].F));
      }
    }
    determined = determined && !(norm(F) + norm(T) / std::max(size, 1e-300) > undetermined_above);
  });
  return determined;
}

}  // namespace momentree
