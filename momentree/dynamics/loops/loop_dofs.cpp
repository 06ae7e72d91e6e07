// Coordinates and velocities of loop joints, and the rows of their single DoFs: of prescribed motions and of armatures.
//
// An armature of inertia I adds I jᵀ j to the mass matrix, where u_l = j u is the velocity of the DoF. This is a soft row: its
// multiplier −I u̇_l satisfies (A λ)_j + λ_j / I = −(b + drift)_j.
#include <algorithm>

#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/math/joint_mass.hpp>

namespace momentree {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Motion<double> relative_motion(const LoopPlace& p, const Mat3& Rb) {  // of the child side in the parent side, in axes Rb
  const Vec3 v = p.vb - p.va - cross(p.wa, p.xb - p.xa);
  return {transpose_times(Rb, v), transpose_times(Rb, p.wb - p.wa)};
}

double product(const Motion<double>& x, const Motion<double>& y) { return dot(x.v, y.v) + dot(x.w, y.w); }

// Columns E at present, and the inverse of Eᵀ E: u = (Eᵀ E)⁻¹ Eᵀ (relative motion).
struct Dofs {
  Motion<double> E[6];
  JointMass<double, 6> squares;
  int count = 0;

  Dofs(const JointSpec& spec, const double* q) {
    count = joint_columns(spec, q, E);
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < i; ++j) squares(i, j) = i < count ? product(E[i], E[j]) : 0;
      squares(i, i) = i < count ? product(E[i], E[i]) : 1;
    }
    squares.factorise();
  }
  void velocities(const Motion<double>& relative, double* u) const {
    double right[6] = {};
    for (int i = 0; i < count; ++i) right[i] = product(E[i], relative);
    squares.solve(right);
    std::copy_n(right, count, u);
  }
  // The row of (Eᵀ E)⁻¹ Eᵀ of one DoF.
  Motion<double> row(int dof) const {
    double right[6] = {};
    right[dof] = 1;
    squares.solve(right);
    Motion<double> w{};
    for (int i = 0; i < count; ++i) w = w + Motion<double>{right[i] * E[i].v, right[i] * E[i].w};
    return w;
  }
};

// The row times the felt accelerations of the last outward pass; `base`: that of the ground.
double relative_rate(const Tree& tree, const double* q, const Workspace<double>& workspace, int place, const LoopRow& row,
                     const Motion<double>& base) {
  const Loop& loop = tree.loops()[at(place)];
  const auto part = [&](int b) {
    return dot(felt_acceleration(tree, q, workspace, b),
               on_body(workspace.bodies[at(b)], row.F, row.T, workspace.loops->places[at(place)].xb));
  };
  return part(loop.body) - (loop.to >= 0 ? part(loop.to) : dot(row.F, base.v));
}

// What is locked is where it is held, to the bit.
void put_held(const Loop& loop, double* q) noexcept {
  const KindInfo& kind = info(loop.joint.kind);
  for (int k = 0; k < kind.nv && kind.nq == kind.nv; ++k)
    if ((loop.joint.locked >> k & 1u) != 0) q[k] = loop.held[k];
  if (kind.nq != kind.nv && loop.joint.locked + 1 == 1u << kind.nv) std::copy_n(loop.held.begin(), kind.nq, q);
}

}  // namespace

Mat3 loop_child_axes(const LoopPlace& p, const LoopLink& link) noexcept {
  return p.Ra * (p.R * transpose(rotation_matrix(link.child_offset.rotation)));
}
Pose loop_pose(const LoopPlace& p, const LoopLink& link) noexcept {
  return link.parent_offset * (Pose{p.r, quaternion_of(p.R)} * inverse(link.child_offset));
}

void loop_coordinates(const Tree& tree, const Workspace<double>& workspace, int place, double* q, double* u) noexcept {
  const LoopWorkspace& loops = *workspace.loops;
  detail::loop_coordinates_at(tree, place, loops.places[at(place)], loops.turns[at(place)], q, u);
}
void detail::loop_coordinates_at(const Tree& tree, int place, const LoopPlace& p, const Turns& turns, double* q,
                                 double* u) noexcept {
  const LoopLink& link = tree.loops().links[at(place)];
  const JointSpec spec = spec_of(tree.loops()[at(place)].joint);
  nearest_coordinates(spec, loop_pose(p, link), turns, q);
  Dofs(spec, q).velocities(relative_motion(p, loop_child_axes(p, link)), u);
}
Turns detail::turns_at(const Tree& tree, int place, const LoopPlace& p, const Turns& hint) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  double q[7] = {};
  nearest_coordinates(spec_of(loop.joint), loop_pose(p, tree.loops().links[at(place)]), hint, q);
  put_held(loop, q);
  return turns_of(loop.joint.kind, q);
}

void held_loop_coordinates(const Tree& tree, const Workspace<double>& workspace, int place, double* q, double* u) noexcept {
  loop_coordinates(tree, workspace, place, q, u);
  const Loop& loop = tree.loops()[at(place)];
  put_held(loop, q);
  for (int k = 0; k < info(loop.joint.kind).nv; ++k)
    if ((loop.joint.locked >> k & 1u) != 0) u[k] = 0;
}

void loop_joint_values(const Tree& tree, double t, const double* q, const double* u, std::span<const Turns> turns,
                       Workspace<double>& workspace, int place, double* loop_q, double* loop_u) {
  LoopWorkspace& loops = detail::loop_memory(tree, workspace);
  std::copy(turns.begin(), turns.end(), loops.turns.begin());
  detail::set_loop_motions(tree, t, workspace);
  sweep_velocities<double, true>(tree, q, u, workspace);
  detail::place_loops(tree, q, workspace, true);
  held_loop_coordinates(tree, workspace, place, loop_q, loop_u);
}

namespace {
LoopRow velocity_row(const Loop& loop, const LoopLink& link, const LoopPlace& p, const Turns& turns, int dof) {
  const JointSpec spec = spec_of(loop.joint);
  double q[7] = {}, u[6] = {};
  nearest_coordinates(spec, loop_pose(p, link), turns, q);
  const Dofs dofs(spec, q);
  const Mat3 Rb = loop_child_axes(p, link);
  dofs.velocities(relative_motion(p, Rb), u);
  const Motion<double> w = dofs.row(dof);
  const Vec3 v = p.vb - p.va - cross(p.wa, p.xb - p.xa), relative = p.wb - p.wa;
  LoopRow row;
  row.F = Rb * w.v, row.T = Rb * w.w;
  row.residual = info(spec.kind).nq == info(spec.kind).nv ? q[dof] : 0;
  row.velocity = u[dof];
  row.rate = cross(p.wb, row.T);
  row.drift = dot(cross(p.wb, row.F), v) + dot(row.F, cross(relative, p.vb)) + dot(row.rate, relative) -
              product(w, joint_columns_drift(spec, q, u));
  return row;
}
}  // namespace

LoopRow loop_dof_row(const Tree& tree, const Workspace<double>& workspace, int place, int dof) noexcept {
  const LoopWorkspace& loops = *workspace.loops;
  return velocity_row(tree.loops()[at(place)], tree.loops().links[at(place)], loops.places[at(place)], loops.turns[at(place)],
                      dof);
}

// With E⁺ᵀ = E S, S = (Eᵀ E)⁻¹: its derivative is Ė S − E S (Ėᵀ E + Eᵀ Ė) S.
LoopWrenchRate loop_dof_rate(const Tree& tree, const Workspace<double>& workspace, int place, int dof) noexcept {
  const LoopPlace& p = workspace.loops->places[at(place)];
  const LoopLink& link = tree.loops().links[at(place)];
  const JointSpec spec = spec_of(tree.loops()[at(place)].joint);
  double q[7] = {}, u[6] = {}, s[6] = {}, turned[6] = {};
  nearest_coordinates(spec, loop_pose(p, link), workspace.loops->turns[at(place)], q);
  const Dofs dofs(spec, q);
  const Mat3 Rb = loop_child_axes(p, link);
  dofs.velocities(relative_motion(p, Rb), u);
  Motion<double> rates[6], w{}, rate{};
  joint_columns_rate(spec, q, u, rates);
  s[dof] = 1;
  dofs.squares.solve(s);
  const auto combined = [&](const Motion<double>* columns, const double* x) {
    Motion<double> sum{};
    for (int i = 0; i < dofs.count; ++i) sum = sum + Motion<double>{x[i] * columns[i].v, x[i] * columns[i].w};
    return sum;
  };
  w = combined(dofs.E, s), rate = combined(rates, s);
  for (int i = 0; i < dofs.count; ++i) turned[i] = -product(rates[i], w) - product(dofs.E[i], rate);
  dofs.squares.solve(turned);
  rate = rate + combined(dofs.E, turned);
  return {cross(p.wb, Rb * w.v) + Rb * rate.v, cross(p.wb, Rb * w.w) + Rb * rate.w};
}

LoopRow detail::dof_row(const Tree& tree, int place, const DofRow& of, const LoopPlace& p, const Turns& turns,
                        const Curve::Point& motion) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  LoopRow row = velocity_row(loop, tree.loops().links[at(place)], p, turns, of.dof);
  if (of.use == DofRow::Use::motion) {
    row.residual -= motion.value, row.velocity -= motion.rate, row.drift -= motion.acceleration;
    row.jump_to = motion.rate;
  } else if (of.use == DofRow::Use::armature) {
    row.jump_to = row.velocity;
    row.residual = row.velocity = 0;
    row.softness = 1 / of.armature;
  } else if (info(loop.joint.kind).nq == info(loop.joint.kind).nv) {
    row.residual -= loop.held[of.dof];
  }
  return row;
}

Motion<double> detail::dof_direction(const JointSpec& joint, const double* q, int dof) noexcept {
  return Dofs(joint, q).row(dof);
}

void detail::add_extra_efforts(const Tree& tree, const LoopWorkspace& loops, double* force) noexcept {
  if (loops.efforts == nullptr) return;
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      if ((tree.link(b).locked >> i & 1u) == 0) force[tree.first_p(b) + i] += loops.efforts[tree.first_p(b) + i];
}

void detail::set_loop_motions(const Tree& tree, double t, Workspace<double>& workspace) noexcept {
  if (tree.loops().motions > 0) set_loop_motions(tree, &t, 1, loop_memory(tree, workspace));
}
void detail::set_loop_motions(const Tree& tree, const double* t, int lanes, LoopConstants& loops) noexcept {
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    if (!loop.driven()) continue;
    for (int l = 0; l < lanes; ++l) {
      const std::size_t entry = i * at(lanes) + at(l);
      loops.motions[entry] = loop.motion().at(t[l]);
      if (info(loop.joint.kind).q_units[0] == 'r') loops.turns[entry].first = loops.motions[entry].value;
    }
  }
}

void carry_armatures(const Tree& tree, Workspace<double>& workspace) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  loops.carried.clear();
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    if (!loop.parameters.armature.any()) continue;
    double q[7] = {}, u[6] = {};
    loop_coordinates(tree, workspace, static_cast<int>(i), q, u);
    for (int k = 0; k < info(loop.joint.kind).nv; ++k) loops.carried.push_back({loop.number, k, u[k]});
  }
}

void detail::keep_armatures(const Tree& tree, Workspace<double>& workspace) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const LoopLink& link = tree.loops().links[i];
    for (int k = 0; k < link.dof_row_count; ++k) {
      const DofRow& of = link.dof_rows[at(k)];
      if (of.use != DofRow::Use::armature) continue;
      LoopRow& row = loops.rows[at(link.first_row + link.closure.rows() + k)];
      for (const ArmatureSpeed& armature : loops.carried)
        if (armature.loop == tree.loops()[i].number && armature.dof == of.dof) row.jump_to = armature.speed;
    }
  }
}

double loop_acceleration(const Tree& tree, const double* q, const Workspace<double>& workspace, int place, int dof) noexcept {
  const LoopRow row = loop_dof_row(tree, workspace, place, dof);
  return row.drift + relative_rate(tree, q, workspace, place, row, {-tree.gravity(), {}});
}

double strike_loop(const Tree& tree, const double* q, Workspace<double>& workspace, int place, int dof, double* u) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  LoopWorkspace& loops = *workspace.loops;
  const LoopRow row = loop_dof_row(tree, workspace, place, dof);
  const Vec3& x = loops.places[at(place)].xb;
  for (const int b : tree.order()) workspace.biases[at(b)] = {};
  std::fill_n(workspace.a.get(), tree.nv(), 0.0);
  workspace.biases[at(loop.body)].wrench = -1.0 * on_body(workspace.bodies[at(loop.body)], row.F, row.T, x);
  if (loop.to >= 0) workspace.biases[at(loop.to)].wrench = on_body(workspace.bodies[at(loop.to)], row.F, row.T, x);
  reduce_accelerations<double, true>(tree, q, workspace);
  for (LoopRow& each : loops.rows) each.jump_to = 0;
  solve_loops(tree, q, workspace, {}, LoopRows::choose, true);
  resolve_accelerations<double, true>(tree, q, workspace, {});
  std::copy_n(workspace.a.get(), tree.nv(), u);
  loops.strike = {place, {row.F, row.T}};
  return relative_rate(tree, q, workspace, place, row, {});
}

double loop_armature_energy(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  if (!loop.parameters.armature.any()) return 0;
  double q[7] = {}, u[6] = {}, energy = 0;
  loop_coordinates(tree, workspace, place, q, u);
  for (int i = 0; i < info(loop.joint.kind).nv; ++i)
    if ((loop.joint.locked >> i & 1u) == 0) energy += 0.5 * loop.parameters.armature.of(i) * u[i] * u[i];
  return energy;
}

LoopMotion loop_motion(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  const LoopLink& link = tree.loops().links[at(place)];
  if (!loop.driven()) return {};
  const Curve::Point& s = workspace.loops->motions[at(place)];
  return {workspace.loops->lambda[at(link.first_row + link.closure.rows())], s.rate,
          loop.parameters.armature.of(0) * s.acceleration};
}

}  // namespace momentree
