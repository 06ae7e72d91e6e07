// Where the loops' frames are, what their rows are there, and the forces in loop joints.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <momentree/dynamics/forces/elements.hpp>
#include <momentree/dynamics/loop_system.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/math/joint_mass.hpp>

namespace momentree {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double stiffest_armature = 1e6;  // a soft row is never redundant, however large the armature is beside the bodies

// The joint frame on one side: axes and origin in the world, velocity of the point at x and angular velocity there.
struct Side {
  Mat3 R;
  Vec3 x;
};
Side side_of(const Workspace<double>& workspace, int body, const KernelFrame& frame) {
  if (body < 0) return {frame.R, frame.r};
  const Kinematics<double>& k = workspace.bodies[at(body)];
  return {k.R * frame.R, k.r + k.R * frame.r};
}
void velocity_at(const Workspace<double>& workspace, int body, const Vec3& x, Vec3& v, Vec3& w) {
  v = w = {};
  if (body < 0) return;
  const Kinematics<double>& k = workspace.bodies[at(body)];
  w = k.R * k.velocity.w;
  v = k.R * k.velocity.v + cross(w, x - k.r);
}

// wᵀ M⁻¹ w for a wrench on a free body: what the row's element of A is at most. 1 for a body without mass.
double mobility(const RigidMass& body, const Force<double>& w) {
  if (!(body.m > 0)) return 1;
  const Vec3 c = (1 / body.m) * body.mc;
  const Vec3 t = w.h - cross(c, w.l);
  JointMass<double, 3> J;
  const auto& O = body.J;
  const double cc = dot(c, c), m = body.m;
  J(0, 0) = O.xx - m * (cc - c.x * c.x), J(1, 1) = O.yy - m * (cc - c.y * c.y), J(2, 2) = O.zz - m * (cc - c.z * c.z);
  J(1, 0) = O.xy + m * c.x * c.y, J(2, 0) = O.xz + m * c.x * c.z, J(2, 1) = O.yz + m * c.y * c.z;
  const double least = 1e-6 * (J(0, 0) + J(1, 1) + J(2, 2)) + 1e-300;  // rods and points have no inertia about some axes
  for (int i = 0; i < 3; ++i) J(i, i) += least;
  J.factorise();
  double a[3] = {t.x, t.y, t.z};
  J.solve(a);
  const double s = dot(w.l, w.l) / m + t.x * a[0] + t.y * a[1] + t.z * a[2];
  return s > 0 && std::isfinite(s) ? s : 1;
}

double screw_angle(const Closure::Screw& screw, const Mat3& R, double turn) {
  const Vec3 e1 = R * screw.e1, e2 = R * screw.e2;
  const double angle = std::atan2(dot(screw.e2, e1) - dot(screw.e1, e2), dot(screw.e1, e1) + dot(screw.e2, e2));
  return angle + 2 * std::numbers::pi * std::round((turn - angle) / (2 * std::numbers::pi));
}

// Writes φ, F, T and Ṫ of the wanted rows of a closure (a bit each), in the parent-side frame: φ̇ = F·v + T·ω for the relative
// velocities there.
template <class Put>
void closure_rows(const Closure& c, unsigned wanted, const Mat3& R, const Vec3& r, const Vec3& w, double turn, const Put& put) {
  for (int i = 0; i < c.positions; ++i)
    if ((wanted >> i & 1u) != 0) put(i, dot(c.position[at(i)], r), c.position[at(i)], Vec3{}, Vec3{});
  for (int i = 0; i < c.directions; ++i) {
    if ((wanted >> (c.positions + i) & 1u) == 0) continue;
    const Closure::Direction& d = c.direction[at(i)];
    const Vec3 b = R * d.b;
    put(c.positions + i, dot(d.a, b) - d.c, Vec3{}, cross(b, d.a), cross(cross(w, b), d.a));
  }
  if (c.screws == 0 || (wanted >> (c.positions + c.directions) & 1u) == 0) return;
  const Closure::Screw& s = c.screw;
  const Vec3 e1 = R * s.e1, e2 = R * s.e2;
  const double si = dot(s.e2, e1) - dot(s.e1, e2), co = dot(s.e1, e1) + dot(s.e2, e2), square = si * si + co * co;
  const Vec3 ts = cross(e1, s.e2) - cross(e2, s.e1), tc = cross(e1, s.e1) + cross(e2, s.e2);
  const Vec3 d1 = cross(w, e1), d2 = cross(w, e2);
  const double sd = dot(s.e2, d1) - dot(s.e1, d2), cd = dot(s.e1, d1) + dot(s.e2, d2);
  const Vec3 tsd = cross(d1, s.e2) - cross(d2, s.e1), tcd = cross(d1, s.e1) + cross(d2, s.e2);
  const Vec3 gradient = (1 / square) * (co * ts - si * tc);
  const Vec3 rate = (1 / square) * (cd * ts + co * tsd - sd * tc - si * tcd - (2 * (si * sd + co * cd)) * gradient);
  put(c.positions + c.directions, dot(s.n, r) - s.h * screw_angle(s, R, turn), s.n, -s.h * gradient, -s.h * rate);
}

// By loop: the largest radius of gyration about the origin of its frame, of the bodies between the loop and the ground (m).
void find_extents(const Tree& tree, std::vector<double>& extents) {
  extents.assign(tree.loops().size(), 0.0);
  for (const LoopStop& stop : tree.loop_stops()) {
    if (at(stop.loop) >= extents.size()) continue;  // of a coupling
    const RigidMass& mass = tree.link(stop.body).body;
    const double radius = mass.m > 0 ? std::sqrt((mass.J.xx + mass.J.yy + mass.J.zz) / (2 * mass.m)) : 0;
    if (std::isfinite(radius)) extents[at(stop.loop)] = std::max(extents[at(stop.loop)], radius);
  }
  for (double& extent : extents)
    if (!(extent > 0)) extent = 1;
}

}  // namespace

Force<double> on_body(const Kinematics<double>& body, const Vec3& F, const Vec3& T, const Vec3& x) noexcept {
  return {transpose_times(body.R, F), transpose_times(body.R, T + cross(x - body.r, F))};
}

LoopWorkspace& detail::loop_memory(const Tree& tree, Workspace<double>& workspace) {
  if (workspace.loops == nullptr) workspace.loops = {new LoopWorkspace, [](LoopWorkspace* all) { delete all; }};
  LoopWorkspace& loops = *workspace.loops;
  if (loops.topology == tree.revision()) return loops;
  const std::size_t n = tree.loops().size(), rows = at(tree.loop_rows());
  loops.sizes.resize(tree.loop_links().size() - n);
  loops.topology = tree.revision();
  loops.places.resize(n), loops.turns.resize(n), loops.motions.resize(n);
  find_extents(tree, loops.extents);
  loops.rows.assign(rows, {}), loops.columns.assign(at(tree.loop_columns()), {});
  std::vector<int>& all = loops.choice.taken;
  all.resize(rows);
  std::iota(all.begin(), all.end(), 0);
  detail::lay_out(tree, all, loops.all);
  loops.kept = loops.all;  // for its memory
  loops.A.resize(loops.all.elements), loops.factor.resize(loops.all.elements), loops.least_pivots.resize(rows);
  loops.b.resize(2 * rows), loops.lambda.resize(rows);
  loops.gauge.assign(rows, 0.0);
  loops.u.resize(at(tree.nv()));
  loops.momenta.resize(at(tree.bodies())), loops.wrenches.resize(at(tree.bodies()));
  loops.choice.reserve(tree.loop_links().size(), rows, loops.all.elements);
  loops.carried.reserve(6 * n);
  loops.rank = -1;
  return loops;
}

void detail::place_loops(const Tree& tree, const double* q, Workspace<double>& workspace, bool moving, LoopRows which) noexcept {
  LoopWorkspace& loops = loop_memory(tree, workspace);
  if (loops.rank < 0) which = LoopRows::choose;
  for (std::size_t s = 0, last = tree.loop_stops().size(); s < last; ++s) {
    const int b = tree.loop_stops()[s].body;
    if (s > 0 && tree.loop_stops()[s - 1].body == b) continue;
    const int outer = tree.parent(b);
    Kinematics<double>& own = workspace.bodies[at(b)];
    const DenseTransform<double> x = dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
      return dense_transform<typename decltype(tag)::type, double>(tree.link(b), joint_state(tree, q, workspace, b));
    });
    own.R = outer < 0 ? x.R : workspace.bodies[at(outer)].R * x.R;
    own.r = outer < 0 ? x.r : workspace.bodies[at(outer)].r + workspace.bodies[at(outer)].R * x.r;
    if (moving) own.velocity = workspace.motions[at(b)].velocity;
  }
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    const LoopLink& link = tree.loop_links()[i];
    const Side a = side_of(workspace, loop.to, link.parent), b = side_of(workspace, loop.body, link.child);
    LoopPlace& p = loops.places[i];
    p.Ra = a.R, p.xa = a.x, p.xb = b.x;
    p.R = transpose(a.R) * b.R, p.r = transpose_times(a.R, b.x - a.x);
    p.va = p.wa = p.vb = p.wb = {};
    if (moving) velocity_at(workspace, loop.to, p.xa, p.va, p.wa), velocity_at(workspace, loop.body, p.xb, p.vb, p.wb);
    p.size = norm(a.x) + norm(b.x) + norm(workspace.bodies[at(loop.body)].r) + norm(link.child.r) + norm(link.parent.r);
    p.size = std::max(p.size, loops.extents[i]);  // everything may be at the origin
    const Vec3 wr = transpose_times(a.R, p.wb - p.wa);
    const Vec3 v = p.vb - p.va - cross(p.wa, p.xb - p.xa), turning = cross(p.wb - p.wa, p.vb);
    unsigned wanted = ~0u;
    if (which == LoopRows::kept) {
      wanted = 0;
      for (int k = loops.kept.first_of[i]; k < loops.kept.first_of[i + 1]; ++k)
        wanted |= 1u << (loops.kept.rows[at(k)] - link.first_row);
    }
    const auto put = [&](int k, double phi, const Vec3& F, const Vec3& T, const Vec3& Tdot) {
      LoopRow& to = loops.rows[at(link.first_row + k)];
      to.residual = phi, to.softness = to.jump_to = 0;
      to.F = a.R * F, to.T = a.R * T;
      to.velocity = dot(to.F, v) + dot(to.T, p.wb - p.wa);
      to.rate = cross(p.wa, to.T) + a.R * Tdot;
      to.drift = dot(cross(p.wa, to.F), v) + dot(to.F, turning) + dot(to.rate, p.wb - p.wa);
    };
    closure_rows(link.closure, wanted, p.R, p.r, wr, loops.turns[i].first, put);
    if (link.dof_row_count > 0) place_dof_rows(tree, workspace, static_cast<int>(i));
  }
  place_couplings(tree, q, workspace, moving);
}

void detail::place_couplings(const Tree& tree, const double* q, Workspace<double>& workspace, bool moving) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  const std::size_t first = tree.loops().size();
  for (std::size_t i = first; i < tree.loop_links().size(); ++i) {
    const LoopLink& link = tree.loop_links()[i];
    const CouplingEnds& ends = link.ends;
    const Coupling& coupling = tree.couplings()[at(ends.coupling)];
    const bool leads = ends.follows >= 0;
    const double x = leads ? q[tree.first_q(ends.follows)] : 0, own = q[tree.first_q(ends.joint)];
    LoopRow& row = loops.rows[at(link.first_row)];
    row.F = row.T = {};
    row.residual = own - coupling.value(x);
    row.slope = coupling.slope(x);
    const double rate = moving && leads ? workspace.v[at(tree.first_p(ends.follows))] : 0;
    row.velocity = moving ? workspace.v[at(tree.first_p(ends.joint))] - row.slope * rate : 0;
    row.drift = -coupling.curvature(x) * rate * rate;
    const bool length = info(tree.kind(ends.joint)).q_units[0] == 'm';
    const double far = norm(workspace.bodies[at(ends.joint)].r) + (leads ? norm(workspace.bodies[at(ends.follows)].r) : 0.0);
    loops.sizes[i - first] = std::fabs(own) + coupling.size(x) + (length ? far : 1.0);
  }
}

double coupling_effort(const Tree& tree, const Workspace<double>& workspace, int body) noexcept {
  double effort = 0;
  for (std::size_t i = tree.loops().size(); i < tree.loop_links().size(); ++i) {
    const LoopLink& link = tree.loop_links()[i];
    const auto row = at(link.first_row);
    if (link.ends.joint == body) effort += workspace.loops->lambda[row];
    if (link.ends.follows == body) effort -= workspace.loops->rows[row].slope * workspace.loops->lambda[row];
  }
  return effort;
}

int coupling_place(const Tree& tree, int coupling) noexcept {
  for (std::size_t i = tree.loops().size(); i < tree.loop_links().size(); ++i)
    if (tree.loop_links()[i].ends.coupling == coupling) return static_cast<int>(i);
  return -1;
}

void detail::scale_rows(const Tree& tree, Workspace<double>& workspace) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    const LoopLink& link = tree.loop_links()[i];
    for (int k = 0; k < link.rows; ++k) {
      LoopRow& row = loops.rows[at(link.first_row + k)];
      const auto at_body = [&](int b) {
        return mobility(tree.link(b).body, on_body(workspace.bodies[at(b)], row.F, row.T, loops.places[i].xb));
      };
      row.scale = at_body(loop.body) + (loop.to >= 0 ? at_body(loop.to) : 0.0);
      row.scale = std::min(row.scale + row.softness, row.softness > 0 ? stiffest_armature * row.softness : HUGE_VAL);
    }
  }
  // The element of A of a coupling's row is a sum of squares without cancellation; it is zero if both joints are locked.
  for (std::size_t i = tree.loops().size(); i < tree.loop_links().size(); ++i) {
    const auto row = at(tree.loop_links()[i].first_row);
    const double own = loops.all.element(loops.A, row, row);
    loops.rows[row].scale = own > 0 && std::isfinite(own) ? own : 1;
  }
}

// The nearest coordinates give the pose of the joint, unless directions are reversed.
bool loop_flipped(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  const JointSpec spec = spec_of(tree.loops()[at(place)].joint);
  const Pose pose = loop_pose(workspace.loops->places[at(place)], tree.loop_links()[at(place)]);
  double q[7] = {};
  nearest_coordinates(spec, pose, workspace.loops->turns[at(place)], q);
  const Mat3 R = transpose(rotation_matrix(joint_motion(spec, q).rotation)) * rotation_matrix(pose.rotation);
  return R.xx + R.yy + R.zz < 2.9;
}

namespace {

// Energy of a loop joint's spring (J) and its force along the DoFs; zero without one.
double spring_of(const Loop& loop, const double* q, double* force) noexcept {
  const JointParameters& p = loop.parameters;
  if (!p.stiffness.any()) return 0;
  return dispatch(loop.joint.kind, [&](auto tag) {
    using K = typename decltype(tag)::type;
    double stiffness[6] = {}, rest[7] = {};
    for (int i = 0; i < K::info.nv; ++i) stiffness[i] = p.stiffness.of(i);
    if (p.rest.empty())
      K::Kernels::zero(rest);
    else
      for (int i = 0; i < K::info.nq; ++i) rest[i] = p.rest[i];
    return K::Kernels::spring(q, rest, stiffness, force);
  });
}

// The force of springs, dampers, friction, efforts and drives along the DoFs; adds their power.
void joint_force(const Loop& loop, double t, const double* q, const double* u, double* force, Power& power) noexcept {
  const JointParameters& p = loop.parameters;
  const KindInfo& kind = info(loop.joint.kind);
  spring_of(loop, q, force);
  for (int i = 0; i < kind.nv; ++i) {
    const double friction = p.damping.of(i) * u[i], effort = p.effort.of(i);
    force[i] += effort - friction;
    power.dissipated += friction * u[i], power.work += effort * u[i];
  }
  forces::add_elements({p, kind.nv, ~loop.joint.locked, t, q, u, force, &power});
  for (int i = 0; i < kind.nv; ++i)
    if ((loop.joint.locked >> i & 1u) != 0) force[i] = 0;
  if (!p.limits.soft()) return;
  for (int i = 0; i < kind.nv; ++i)  // what a soft stop stores is potential energy
    power.dissipated -= p.limits.stiffness.of(i) * forces::passed(p.limits, i, q[i]) * u[i];
}

}  // namespace

void load_turns(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  LoopWorkspace& loops = detail::loop_memory(tree, workspace);
  std::fill(loops.turns.begin(), loops.turns.end(), Turns{});
  std::copy_n(state.turns().begin(), std::min(loops.turns.size(), state.turns().size()), loops.turns.begin());
}

Force<double> loop_joint_wrench(const Tree& tree, double t, const Workspace<double>& workspace, int place, double* effort,
                                Power* power) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  if (!loop.parameters.any()) return {};
  double q[7] = {}, u[6] = {};
  Power unused;
  loop_coordinates(tree, workspace, place, q, u);
  joint_force(loop, t, q, u, effort, power != nullptr ? *power : unused);
  return joint_wrench(spec_of(loop.joint), q, loop.joint.locked, effort);
}

double loop_holding_force(const Tree& tree, double t, const Workspace<double>& workspace, int place, int dof,
                          double& size) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  const LoopLink& link = tree.loop_links()[at(place)];
  const LoopPlace& p = workspace.loops->places[at(place)];
  double q[7] = {}, u[6] = {}, effort[6] = {}, passive[6] = {};
  loop_coordinates(tree, workspace, place, q, u);
  u[dof] = 0;
  Vec3 F{}, T{};
  for (int i = 0; i < link.rows; ++i) {
    const auto row = at(link.first_row + i);
    F += workspace.loops->lambda[row] * workspace.loops->rows[row].F;
    T += workspace.loops->lambda[row] * workspace.loops->rows[row].T;
  }
  const Mat3 Rb = loop_child_axes(p, link);
  Force<double> W{transpose_times(Rb, F), transpose_times(Rb, T)};
  W += loop_joint_wrench(tree, t, workspace, place, effort);
  Motion<double> E[6];
  joint_columns(spec_of(loop.joint), q, E);
  Power unused;
  Loop free = loop;
  free.joint.locked = 0;
  joint_force(free, t, q, u, passive, unused);
  const double through = dot(E[dof], W);
  size = std::fabs(through) + std::fabs(passive[dof]);
  return through - passive[dof];
}

void add_loop_forces(const Tree& tree, double t, Workspace<double>& workspace) noexcept {
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    if (!loop.parameters.any()) continue;
    double effort[6] = {};
    const Force<double> W = loop_joint_wrench(tree, t, workspace, static_cast<int>(i), effort, &workspace.power);
    const LoopPlace& p = workspace.loops->places[i];
    const Mat3 Rb = loop_child_axes(p, tree.loop_links()[i]);
    const Vec3 F = Rb * W.l, T = Rb * W.h;
    Force<double>& child = workspace.biases[at(loop.body)].wrench;
    child = child - on_body(workspace.bodies[at(loop.body)], F, T, p.xb);
    if (loop.to < 0) continue;
    Force<double>& parent = workspace.biases[at(loop.to)].wrench;
    parent += on_body(workspace.bodies[at(loop.to)], F, T, p.xb);
  }
}

double loop_energy(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  if (!loop.parameters.any()) return 0;
  double q[7] = {}, u[6] = {}, force[6] = {};
  loop_coordinates(tree, workspace, place, q, u);
  const double energy = spring_of(loop, q, force);
  return loop.parameters.limits.soft() ? energy + forces::soft_stop_energy(loop.parameters, info(loop.joint.kind).nv, q) : energy;
}

}  // namespace momentree
