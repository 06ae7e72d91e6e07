#include <momentree/simulate/assembly.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/loop_workspace.hpp>
#include <momentree/dynamics/loops.hpp>
#include <momentree/dynamics/momentum.hpp>

namespace momentree {

namespace {

constexpr double closed_at_start = 1e-9;  // of loops that must not be assembled
constexpr double left_as_given = 2e-11;   // what the first step closes: a state that is restored keeps its bits

std::string short_text(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.2g", x);
  return buffer;
}

// Joints that follow others move to where they belong, leaders before followers; the assembly closes what cannot be closed so.
void follow_leaders(const Tree& tree, std::size_t first, double* q, double* u) {
  const auto links = tree.loop_links();
  std::vector<int> waiting(static_cast<std::size_t>(tree.bodies()), 0);  // by body: couplings that are to move its joint
  std::vector<char> moved(waiting.size(), 0), done(links.size(), 0);
  const auto at = [](int b) { return static_cast<std::size_t>(b); };
  for (std::size_t i = first; i < links.size(); ++i) ++waiting[at(links[i].ends.joint)];
  for (bool any = true; any;) {
    any = false;
    for (std::size_t i = first; i < links.size(); ++i) {
      const CouplingEnds& ends = links[i].ends;
      if (done[i] != 0 || (ends.follows >= 0 && waiting[at(ends.follows)] > 0)) continue;
      done[i] = 1, any = true;
      --waiting[at(ends.joint)];
      if (moved[at(ends.joint)] != 0 || tree.link(ends.joint).locked != 0) continue;  // by another coupling; locked or driven
      moved[at(ends.joint)] = 1;
      const Coupling& coupling = tree.couplings()[at(ends.coupling)];
      const double x = ends.follows < 0 ? 0 : q[tree.first_q(ends.follows)];
      const double rate = ends.follows < 0 ? 0 : u[tree.first_p(ends.follows)];
      q[tree.first_q(ends.joint)] = coupling.value(x);
      u[tree.first_p(ends.joint)] = coupling.slope(x) * rate;
    }
  }
}

// Of a state in momenta: by its velocities. It keeps its momenta if nothing had to be closed.
std::optional<Error> assemble_momenta(const Tree& tree, const Model& model, const Names& names, State& state) {
  Workspace<double> workspace(tree);
  evaluate_rates<double>(tree, state.q().data(), state.p().data(), workspace);
  const std::span<const double> v(workspace.v.get(), state.p().size());
  State closed(tree, Variables::velocities);
  closed.assign(state.time(), state.q(), v, tree);
  closed.set_turns(state.turns());
  std::optional<Error> error = assemble(tree, model, names, closed);
  if (error) return error;
  state.set_turns(closed.turns());
  if (std::ranges::equal(closed.q(), state.q()) && std::ranges::equal(closed.u(), v)) return std::nullopt;
  std::vector<double> p(v.size());
  project_momentum(tree, closed.q().data(), closed.u().data(), p.data());
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      if (((tree.link(b).locked & ~unsigned{tree.link(b).driven}) >> i & 1u) != 0)
        p[static_cast<std::size_t>(tree.first_p(b) + i)] = 0;
  state.assign(state.time(), closed.q(), p, tree);
  return std::nullopt;
}

}  // namespace

std::optional<Error> assemble(const Tree& tree, const Model& model, const Names& names, State& state) {
  if (state.variables() == Variables::momenta) return assemble_momenta(tree, model, names, state);
  Workspace<double> workspace(tree);
  std::vector<double> residuals(tree.loop_links().size());
  load_turns(tree, state, workspace);
  loop_residuals(tree, state.time(), state.q().data(), state.u().data(), workspace, residuals.data());
  const std::size_t loops = tree.loops().size();
  const auto where = [&](std::size_t i) {
    if (i < loops) return "loop '" + names.joint(tree.loops()[i].id().index) + "'";
    const Coupling& coupling = tree.couplings()[static_cast<std::size_t>(tree.loop_links()[i].ends.coupling)];
    return "coupling of " + coupling_text(coupling, names.joint(coupling.joint.index),
                                          coupling.leads() ? names.joint(coupling.follows.index) : std::string());
  };
  const auto apart = [&](std::size_t i) { return short_text(residuals[i]) + " of its size"; };
  for (std::size_t i = 0; i < loops; ++i) {
    const auto number = static_cast<std::size_t>(tree.loops()[i].number);
    if (number < model.loops().size() && !model.loops()[number].assemble && !(residuals[i] <= closed_at_start))
      return Error("it is open at the start, by " + apart(i), where(i),
                   "give start values at which it is closed, or leave out 'assemble = false'");
  }
  const double worst = residuals.empty() ? 0 : *std::max_element(residuals.begin(), residuals.end());
  double speed = 1;
  for (const double u : state.u()) speed = std::max(speed, std::fabs(u));
  if (worst <= left_as_given && loop_velocities_open(tree, workspace) <= left_as_given * speed) return std::nullopt;
  std::vector<double> q(state.q().begin(), state.q().end()), u(state.u().begin(), state.u().end());
  follow_leaders(tree, loops, q.data(), u.data());
  if (!assemble_loops(tree, state.time(), q.data(), u.data(), workspace, residuals.data())) {
    if (std::optional<Error> error = conflicting_motions(tree, names, state)) return error;
    const auto i = static_cast<std::size_t>(std::max_element(residuals.begin(), residuals.end()) - residuals.begin());
    if (i >= loops)
      return Error(
          "it can't hold from these start values: it stays open by " + apart(i), where(i),
          "it contradicts other couplings, loops, locks or prescribed motions: leave one of them out, or correct its numbers");
    return Error("it can't be closed from these start values: it stays open by " + apart(i), where(i),
                 "check its bodies, 'at', 'child_at' and axes, or give start values nearer to a closed position");
  }
  for (std::size_t i = 0; i < loops; ++i)
    if (loop_flipped(tree, workspace, static_cast<int>(i)))
      return Error("it closes only with its axes in opposite directions", where(i),
                   "turn one of its frames by half a turn, or give start values nearer to the intended position");
  state.set_turns(workspace.loops->turns);
  const State::Edit edit = state.edit();
  std::copy(q.begin(), q.end(), edit.q.begin());
  std::copy(u.begin(), u.end(), edit.u.begin());
  return std::nullopt;
}

std::optional<Error> beyond_stops(const Tree& tree, const Names& names, const State& state) {
  Workspace<double> workspace(tree);
  forward_dynamics(tree, state, workspace);
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    const JointLimits& limits = loop.parameters.limits;
    if (!limits.hard()) continue;
    double q[7] = {}, u[6] = {};
    loop_coordinates(tree, workspace, static_cast<int>(i), q, u);
    for (int k = 0; k < info(loop.joint.kind).nv; ++k)
      if (q[k] < limits.lower_of(k) - closed_at_start || q[k] > limits.upper_of(k) + closed_at_start)
        return Error("it starts beyond its limits, at " + short_text(q[k]), "loop '" + names.joint(loop.id().index) + "'",
                     "give start values that close the loop within them");
  }
  return std::nullopt;
}

std::optional<Error> check_assembly(const Model& model) {
  if (!model.has_equations()) return std::nullopt;
  const Tree tree(model);
  State state = start_state(model, tree, Variables::velocities);
  const Names names(model);
  if (std::optional<Error> error = assemble(tree, model, names, state)) return error;
  if (std::optional<Error> error = conflicting_motions(tree, names, state)) return error;
  return beyond_stops(tree, names, state);
}

}  // namespace momentree
