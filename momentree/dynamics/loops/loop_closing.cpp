// Closing loops after a step, where little is missing.
#include <algorithm>
#include <cmath>

#include <momentree/dynamics/forces/springs.hpp>
#include <momentree/dynamics/loops/loop_momenta.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/motion.hpp>

namespace momentree {

namespace {

using detail::LoopCorrection;

using detail::closed, detail::most_corrections, detail::nearly_closed;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Kinetic and potential energy (J) at the motions of the last sweep, without that of soft stops.
double energy_at(const Tree& tree, const double* q, Workspace<double>& workspace) {
  locate_stage(tree, q, workspace);
  double energy = -stored_in_loop_stops(tree, workspace), force[6];
  for (const int b : tree.order()) {
    const Kinematics<double>& body = workspace.bodies[at(b)];
    const RigidMass& mass = tree.link(b).body;
    const Motion<double>& velocity = workspace.motions[at(b)].velocity;
    energy += 0.5 * dot(velocity, momentum(mass, velocity)) - mass.m * dot(tree.gravity(), body.r) -
              dot(tree.gravity(), body.R * mass.mc);
  }
  for (int i = 0; i < tree.nv(); ++i) energy += 0.5 * tree.tables().armature[i] * workspace.v[at(i)] * workspace.v[at(i)];
  for (const int b : tree.joints_with().springs) energy += joint_spring(tree, q, b, force);
  for (int s = 0; s < tree.springs().count(); ++s)
    if (spring_acts(tree, s)) energy += tree.springs().law(s).energy(spring_motion(tree, workspace, s).length);
  for (std::size_t i = 0; i < tree.loops().size(); ++i)
    energy += loop_energy(tree, workspace, static_cast<int>(i)) + loop_armature_energy(tree, workspace, static_cast<int>(i));
  return energy;
}

// Corrects the velocities; places, rows and records are those of q.
void close_velocities(LoopCorrection& correction, const double* q, double* u) {
  const Workspace<double>& workspace = correction.workspace;
  correction.solve(q, [&](std::size_t row) { return -workspace.loops->rows[row].velocity; });
  for (int i = 0; i < correction.tree.nv(); ++i) u[i] += workspace.a[at(i)];
}

// Corrects the coordinates; places, rows and records are then those of q. `energy`: less that at the start. Returns false if the
// loops cannot be closed.
bool close_coordinates(LoopCorrection& correction, double* q, const double* u, double& energy) {
  const LoopWorkspace& loops = *correction.workspace.loops;
  double before = HUGE_VAL;
  for (int k = 0;; ++k) {
    correction.evaluate(q, u, 0);
    if (k == 0) energy = -energy_at(correction.tree, q, correction.workspace);
    const double open = detail::most_open(correction.tree, loops);
    if (open <= closed) return true;
    if (!(open < 0.5 * before) || k == most_corrections) return open <= nearly_closed;
    before = open;
    correction.solve(q, [&](std::size_t row) { return -loops.rows[row].residual; });
    detail::displace(correction.tree, correction.workspace.a.get(), 1, q);
  }
}

// Calls f for the roots at stops whose momenta are in axes that move with several DoFs.
template <class F>
void each_moving_root(const Tree& tree, const F& f) {
  const std::span<const LoopStop> stops = tree.loops().stops;
  for (std::size_t s = 0; s < stops.size(); ++s) {
    const int b = stops[s].body;
    if ((s == 0 || stops[s - 1].body != b) && tree.parent(b) < 0 && info(tree.kind(b)).nv > 1) f(b);
  }
}

}  // namespace

bool detail::is_length(const Tree& tree, std::size_t link, int row) noexcept {
  const LoopLink& own = tree.loops().links[link];
  const int rows = own.closure.rows();
  return row >= rows ? info(tree.loops()[link].joint.kind).q_units[own.dof_rows[at(row - rows)].dof] == 'm'
                     : row < own.closure.positions || row >= own.closure.positions + own.closure.directions;
}

void detail::note_turns(const Tree& tree, Workspace<double>& workspace) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  for (std::size_t i = 0; i < tree.loops().size(); ++i)
    loops.turns[i] = turns_at(tree, static_cast<int>(i), loops.places[i], loops.turns[i]);
}

void detail::displace(const Tree& tree, const double* delta, double scale, double* q) noexcept {
  for (const int b : tree.order())
    dispatch(tree.kind(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (K::info.nv > 0) {
        double rate[7] = {}, part[6] = {};
        for (int i = 0; i < K::info.nv; ++i) part[i] = scale * delta[tree.first_p(b) + i];
        if (std::all_of(part, part + K::info.nv, [](double x) { return x == 0; })) return;  // it keeps its bits
        double* const own = q + tree.first_q(b);
        K::Kernels::template coordinate_rate<double>(own, part, rate);
        for (int i = 0; i < K::info.nq; ++i) own[i] += rate[i];
        K::Kernels::normalise(own);
      }
    });
}

bool close_loops(const Tree& tree, double t, double* q, double* u, Workspace<double>& workspace, double& energy) noexcept {
  detail::loop_memory(tree, workspace);
  detail::set_loop_motions(tree, t, workspace);
  LoopCorrection correction{tree, workspace};
  if (!close_coordinates(correction, q, u, energy)) return false;
  close_velocities(correction, q, u);
  sweep_velocities<double, true>(tree, q, u, workspace);
  detail::place_loops(tree, q, workspace, true);
  energy += energy_at(tree, q, workspace);
  detail::note_turns(tree, workspace);
  return true;
}

void close_loop_velocities(const Tree& tree, double t, const double* q, double* u, Workspace<double>& workspace,
                           std::span<double> open) noexcept {
  detail::loop_memory(tree, workspace);
  detail::set_loop_motions(tree, t, workspace);
  LoopCorrection correction{tree, workspace};
  correction.evaluate(q, u, 0);
  close_velocities(correction, q, u);
  sweep_velocities<double, true>(tree, q, u, workspace);
  detail::place_loops(tree, q, workspace, true);
  for (std::size_t i = 0; i < open.size(); ++i) {
    const LoopLink& link = tree.loops().links[i];
    open[i] = 0;
    for (int row = 0; row < link.rows; ++row)
      open[i] = std::max(open[i], std::fabs(workspace.loops->rows[at(link.first_row + row)].velocity));
  }
}

void keep_loops_closed(const Tree& tree, double t, const double* q, const double* u, double* du,
                       Workspace<double>& workspace) noexcept {
  detail::set_loop_motions(tree, t, workspace);
  LoopCorrection correction{tree, workspace};
  for (int i = 0; i < tree.nv(); ++i) du[i] += u[i];
  correction.evaluate_kept(q, du);
  correction.solve(q, [&](std::size_t row) { return -workspace.loops->rows[row].velocity; });
  for (int i = 0; i < tree.nv(); ++i) du[i] += workspace.a[at(i)] - u[i];
}

bool close_coordinates_further(const Tree& tree, double t, double* q, const double* u, Workspace<double>& workspace) noexcept {
  constexpr double close = 300;
  detail::set_loop_motions(tree, t, workspace);
  LoopCorrection correction{tree, workspace};
  double before = HUGE_VAL;
  for (int k = 0;; ++k) {
    correction.evaluate(q, u, 0);
    const double open = detail::most_open(tree, *workspace.loops), clearance = loop_clearance(workspace);
    if (open <= closed * std::min(1.0, close * clearance * clearance) || !(open < 0.5 * before) || k == most_corrections)
      return k > 0;
    before = open;
    correction.solve(q, [&](std::size_t row) { return -workspace.loops->rows[row].residual; });
    detail::displace(tree, workspace.a.get(), 1, q);
  }
}

bool close_loops_in_momenta(const Tree& tree, double t, double* q, double* p, Workspace<double>& workspace,
                            double& energy) noexcept {
  detail::set_loop_motions(tree, t, workspace);
  find_velocities_with_loops(tree, q, p, workspace);
  LoopWorkspace& loops = *workspace.loops;
  std::copy_n(workspace.v.get(), tree.nv(), loops.u.begin());
  // The articulated momenta of roots, in the world. A root's own p is put in their place, at its corrected coordinates.
  each_moving_root(tree, [&](int b) {
    const Kinematics<double>& body = workspace.bodies[at(b)];
    const Force<double>& P = workspace.motions[at(b)].articulated;
    absorb(tree, b, joint_state(tree, q, workspace, b), P, -1, p);
    const Vec3 l = body.R * P.l;
    loops.momenta[at(b)] = {l, body.R * P.h + cross(body.r, l)};
  });
  LoopCorrection correction{tree, workspace};
  if (!close_coordinates(correction, q, loops.u.data(), energy)) return false;
  each_moving_root(tree, [&](int b) {
    const Force<double>& P = loops.momenta[at(b)];
    absorb(tree, b, joint_state(tree, q, workspace, b), on_body(workspace.bodies[at(b)], P.l, P.h, {}), +1, p);
  });
  find_velocities_with_loops(tree, q, p, workspace);
  loops.gauge = loops.lambda;
  detail::place_loops(tree, q, workspace, true);
  detail::sum_loop_momenta(tree, q, workspace, loops.gauge.data());
  const std::span<const LoopStop> stops = tree.loops().stops;
  for (std::size_t s = 0; s < stops.size(); ++s)
    if (const int b = stops[s].body; s == 0 || stops[s - 1].body != b)
      absorb(tree, b, joint_state(tree, q, workspace, b), loops.momenta[at(b)], +1, p);
  add_coupling_efforts(tree, workspace, loops.gauge.data(), p);
  energy += energy_at(tree, q, workspace);
  detail::note_turns(tree, workspace);
  return true;
}

void loop_residuals(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace,
                    double* residuals) noexcept {
  detail::loop_memory(tree, workspace);
  detail::set_loop_motions(tree, t, workspace);
  sweep_velocities<double, true>(tree, q, u, workspace);
  detail::place_loops(tree, q, workspace, true);
  for (std::size_t i = 0; i < tree.loops().links.size(); ++i) residuals[i] = detail::open_by(tree, *workspace.loops, i);
}

int independent_rows(const Tree& tree, double t, const double* q, Workspace<double>& workspace) {
  detail::loop_memory(tree, workspace);
  detail::set_loop_motions(tree, t, workspace);
  const std::vector<double> rest(at(tree.nv()), 0.0);
  LoopCorrection correction{tree, workspace};
  correction.evaluate(q, rest.data(), 0);
  return workspace.loops->rank - tree.loops().armatures;
}

LoopStatus loop_status(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  LoopStatus status;
  if (!tree.has_loops()) return status;
  forward_dynamics(tree, state, workspace);
  const LoopWorkspace& loops = *workspace.loops;
  status.rows = tree.loops().rows - tree.loops().armatures, status.rank = loops.rank - tree.loops().armatures;
  for (const LoopRow& row : loops.rows) status.residual = std::max(status.residual, std::fabs(row.residual));
  return status;
}

}  // namespace momentree
