// Where the loops' frames are, what their rows are there, and the forces in loop joints.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <momentree/dynamics/forces/elements.hpp>
#include <momentree/dynamics/forces/evaluation_context.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/math/joint_mass.hpp>

namespace momentree {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// By loop: the largest radius of gyration about the origin of its frame, of the bodies between the loop and the ground (m).
void find_extents(const Tree& tree, std::vector<double>& extents) {
  extents.assign(tree.loops().size(), 0.0);
  for (const LoopStop& stop : tree.loops().stops) {
    if (at(stop.loop) >= extents.size()) continue;  // of a coupling
    const RigidMass& mass = tree.link(stop.body).body;
    const double radius = mass.m > 0 ? std::sqrt((mass.J.xx + mass.J.yy + mass.J.zz) / (2 * mass.m)) : 0;
    if (std::isfinite(radius)) extents[at(stop.loop)] = std::max(extents[at(stop.loop)], radius);
  }
  for (double& extent : extents)
    if (!(extent > 0)) extent = 1;
}

}  // namespace

void detail::lay_out_constants(const Tree& tree, int lanes, LoopConstants& to) {
  const std::size_t entries = tree.loops().size() * at(lanes);
  to.topology = tree.loops().revision();
  to.turns.resize(entries), to.motions.resize(entries);
  find_extents(tree, to.extents);
  to.all.rows.resize(at(tree.loops().rows));
  std::iota(to.all.rows.begin(), to.all.rows.end(), 0);
  lay_out(tree, to.all.rows, to.all);
  to.kept = to.all;  // for its memory
}

LoopWorkspace& detail::loop_memory(const Tree& tree, Workspace<double>& workspace) {
  if (workspace.loops == nullptr) workspace.loops = {new LoopWorkspace, [](LoopWorkspace* all) { delete all; }};
  LoopWorkspace& loops = *workspace.loops;
  if (loops.topology == tree.loops().revision()) return loops;
  const std::size_t n = tree.loops().size(), rows = at(tree.loops().rows);
  detail::lay_out_loops<double>(tree, loops);
  loops.gauge.assign(rows, 0.0), loops.speeds.assign(rows, 0.0);
  loops.u.resize(at(tree.nv()));
  loops.forces.resize(at(tree.nv() + tree.loops().motions));
  loops.answers.resize(rows + tree.joints_with().motions.size());
  loops.momenta.resize(at(tree.bodies())), loops.wrenches.resize(at(tree.bodies()));
  loops.choice.reserve(tree.loops().links.size(), rows, loops.all.elements);
  loops.carried.reserve(6 * n);
  loops.given.assign(6 * n, 0.0), loops.values.resize(n);
  loops.rank = -1;
  return loops;
}

double detail::screw_angle(double si, double co, double turn) noexcept {
  const double angle = std::atan2(si, co);
  return angle + 2 * std::numbers::pi * std::round((turn - angle) / (2 * std::numbers::pi));
}

detail::CouplingPoint detail::coupling_point(const Tree& tree, int coupling, double x) noexcept {
  const Coupling& c = tree.couplings()[at(coupling)];
  return {c.value(x), c.slope(x), c.curvature(x), c.size(x)};
}
bool detail::is_length(const Tree& tree, int body) noexcept { return info(tree.kind(body)).q_units[0] == 'm'; }

void detail::place_loops(const Tree& tree, const double* q, Workspace<double>& workspace, bool moving, LoopRows which) noexcept {
  LoopWorkspace& loops = loop_memory(tree, workspace);
  if (loops.rank < 0) which = LoopRows::choose;
  place_closures<double>(tree, q, workspace, loops, moving, which);
  place_other_rows<double>(tree, q, workspace, loops, moving);
}

double coupling_effort(const Tree& tree, const Workspace<double>& workspace, int body) noexcept {
  double effort = 0;
  for (std::size_t i = tree.loops().size(); i < tree.loops().links.size(); ++i) {
    const LoopLink& link = tree.loops().links[i];
    const auto row = at(link.first_row);
    if (link.ends.joint == body) effort += workspace.loops->lambda[row];
    if (link.ends.follows == body) effort -= workspace.loops->rows[row].slope * workspace.loops->lambda[row];
  }
  return effort;
}

void add_coupling_efforts(const Tree& tree, const Workspace<double>& workspace, const double* multipliers,
                          double* force) noexcept {
  for (std::size_t i = tree.loops().size(); i < tree.loops().links.size(); ++i) {
    const LoopLink& link = tree.loops().links[i];
    const auto row = at(link.first_row);
    const auto add = [&](int b, double effort) {
      if (b >= 0 && (tree.link(b).locked & 1u) == 0) force[tree.first_p(b)] += effort;
    };
    add(link.ends.joint, multipliers[row]);
    add(link.ends.follows, -workspace.loops->rows[row].slope * multipliers[row]);
  }
}

int coupling_place(const Tree& tree, int coupling) noexcept {
  for (std::size_t i = tree.loops().size(); i < tree.loops().links.size(); ++i)
    if (tree.loops().links[i].ends.coupling == coupling) return static_cast<int>(i);
  return -1;
}

// The nearest coordinates give the pose of the joint, unless directions are reversed.
bool loop_flipped(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  const JointSpec spec = spec_of(tree.loops()[at(place)].joint);
  const Pose pose = loop_pose(workspace.loops->places[at(place)], tree.loops().links[at(place)]);
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

// The force of springs, dampers, friction, efforts and drives along the DoFs, and what a function gave (or null); adds their
// power.
void joint_force(const Loop& loop, double t, const double* q, const double* u, const double* given, double* force,
                 Power& power) noexcept {
  const JointParameters& p = loop.parameters;
  const KindInfo& kind = info(loop.joint.kind);
  spring_of(loop, q, force);
  for (int i = 0; i < kind.nv; ++i) {
    const double friction = p.damping.of(i) * u[i];
    const bool free = (loop.joint.locked >> i & 1u) == 0;
    const double effort = p.effort.of(i) + (given != nullptr && free ? given[i] : 0.0);
    force[i] += effort - friction;
    power.dissipated += friction * u[i], power.work += effort * u[i];
  }
  forces::add_elements({p, kind.nv, ~loop.joint.locked, t, q, u, force, &power});
  for (int i = 0; i < kind.nv; ++i)
    if ((loop.joint.locked >> i & 1u) != 0) force[i] = 0;
}

}  // namespace

bool detail::has_forces(const Loop& loop) noexcept {
  const JointParameters& p = loop.parameters;
  return p.damping.any() || p.stiffness.any() || p.effort.any() || p.friction.any() || p.limits.soft() ||
         (p.drive != nullptr && (!p.drive->effort.empty() || p.drive->pd.any()));
}

void load_turns(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  LoopWorkspace& loops = detail::loop_memory(tree, workspace);
  std::fill(loops.turns.begin(), loops.turns.end(), Turns{});
  std::copy_n(state.turns().begin(), std::min(loops.turns.size(), state.turns().size()), loops.turns.begin());
}

Force<double> loop_joint_wrench(const Tree& tree, double t, const Workspace<double>& workspace, int place, double* effort,
                                Power* power) noexcept {
  const LoopWorkspace& loops = *workspace.loops;
  Power unused;
  return detail::joint_wrench_at(tree, t, place, loops.places[at(place)], loops.turns[at(place)], loops.given.data() + 6 * place,
                                 effort, power != nullptr ? *power : unused);
}

Force<double> detail::joint_wrench_at(const Tree& tree, double t, int place, const LoopPlace& p, const Turns& turns,
                                      const double* given, double* effort, Power& power) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  if (!loop.forced()) return {};
  double q[7] = {}, u[6] = {};
  loop_coordinates_at(tree, place, p, turns, q, u);
  joint_force(loop, t, q, u, given, effort, power);
  return joint_wrench(spec_of(loop.joint), q, loop.joint.locked, effort);
}

Force<double> detail::loop_force(const Tree& tree, double t, int place, const LoopPlace& p, const Turns& turns,
                                 const double* given, Power& power) noexcept {
  double effort[6] = {};
  const Force<double> W = joint_wrench_at(tree, t, place, p, turns, given, effort, power);
  const Mat3 Rb = loop_child_axes(p, tree.loops().links[at(place)]);
  return {Rb * W.l, Rb * W.h};
}

double loop_holding_force(const Tree& tree, double t, const Workspace<double>& workspace, int place, int dof,
                          double& size) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  const LoopLink& link = tree.loops().links[at(place)];
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
  joint_force(free, t, q, u, workspace.loops->given.data() + 6 * place, passive, unused);
  const double through = dot(E[dof], W);
  size = std::fabs(through) + std::fabs(passive[dof]);
  return through - passive[dof];
}

void add_loop_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  if (has_functions(tree)) {
    const EvaluationContext context(tree, t, q, workspace);
    for (std::size_t i = 0; i < tree.loops().size(); ++i) {
      double* const given = loops.given.data() + 6 * i;
      std::fill_n(given, 6, 0.0);
      if (const JointFunction* function = tree.function(tree.loops()[i].joint))
        (*function)(context, {given, static_cast<std::size_t>(info(tree.loops()[i].joint.kind).nv)});
    }
  } else {
    std::fill(loops.given.begin(), loops.given.end(), 0.0);  // those of functions that are no more
  }
  detail::add_loop_forces<double>(tree, &t, workspace, loops, &workspace.power, loops.given.data());
}

double loop_energy(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  if (!loop.parameters.any()) return 0;
  double q[7] = {}, u[6] = {}, force[6] = {};
  loop_coordinates(tree, workspace, place, q, u);
  const double energy = spring_of(loop, q, force);
  return loop.parameters.limits.soft() ? energy + forces::soft_stop_energy(loop.parameters, info(loop.joint.kind).nv, q) : energy;
}

double stored_in_loop_stops(const Tree& tree, const Workspace<double>& workspace) noexcept {
  double energy = 0, q[7] = {}, u[6] = {};
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    if (!loop.parameters.limits.soft()) continue;
    loop_coordinates(tree, workspace, static_cast<int>(i), q, u);
    energy += forces::soft_stop_energy(loop.parameters, info(loop.joint.kind).nv, q);
  }
  return energy;
}

}  // namespace momentree
