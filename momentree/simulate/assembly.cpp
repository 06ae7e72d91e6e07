#include <momentree/simulate/assembly.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/loops/islands.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

namespace {

constexpr double closed_at_start = 1e-9;  // of loops that must not be assembled, and of the velocities of others
constexpr double left_as_given = 2e-11;   // what the first step closes: a state that is restored keeps its bits
constexpr double rounded_start = 0.02;    // what start values of a few digits leave open

double largest(std::span<const double> u) {  // 1 or more
  double speed = 1;
  for (const double each : u) speed = std::max(speed, std::fabs(each));
  return speed;
}

std::string short_text(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.2g", x);
  return buffer;
}

// Joints that follow others move to where they belong, leaders before followers; the assembly closes what cannot be closed so.
void follow_leaders(const Tree& tree, std::size_t first, double* q, double* u) {
  const std::span<const LoopLink> links = tree.loops().links;
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

// A body of the island that a loop or coupling belongs to.
int end_of_link(const Tree& tree, std::size_t link) {
  if (link >= tree.loops().size()) return tree.loops().links[link].ends.joint;
  const Loop& loop = tree.loops()[link];
  return loop.body >= 0 ? loop.body : loop.to;
}

// Copies the coordinates, or velocities, of an island.
void copy_island(const Tree& tree, const Islands& islands, int island, std::span<const double> from, bool coordinates,
                 std::vector<double>& to) {
  for (const int b : tree.order()) {
    if (islands.of(b) != island) continue;
    const int first = coordinates ? tree.first_q(b) : tree.first_p(b);
    std::copy_n(from.begin() + first, coordinates ? info(tree.kind(b)).nq : info(tree.kind(b)).nv, to.begin() + first);
  }
}

// Given start values that are held while the others close the loops.
class HeldStart {
 public:
  HeldStart(const Tree& tree, const Islands& islands, std::span<const char> given)
      : tree_(tree), islands_(islands), held_(given.begin(), given.end()) {
    held_.resize(static_cast<std::size_t>(tree.nv()));
  }

  bool any() const { return std::ranges::find(held_, 1) != held_.end(); }

  // The tree with these DoFs locked.
  Tree tree() const {
    Tree locked = tree_;
    for (const int b : tree_.order()) {
      Joint joint = tree_.joint(b);
      for (int i = 0; i < info(joint.kind).nv; ++i)
        if (held_[at(tree_.first_p(b) + i)] != 0) joint.locked |= 1u << i;
      if (joint.locked != tree_.joint(b).locked) locked.edit().set_joint(b, joint);
    }
    return locked;
  }

  bool holds(int island) const {
    return any_dof(island, [this](int b, int i) { return held_[at(tree_.first_p(b) + i)] != 0; });
  }

  // Whether nothing else in an island can change.
  bool holds_all(int island) const {
    return !any_dof(
        island, [this](int b, int i) { return held_[at(tree_.first_p(b) + i)] == 0 && (tree_.link(b).locked >> i & 1u) == 0; });
  }

  // Those of an island, or only those whose velocity u is not above `most`. Returns whether any was held.
  bool release(int island, const double* u = nullptr, double most = 0) {
    bool any = false;
    any_dof(island, [&](int b, int i) {
      const int k = tree_.first_p(b) + i;
      if (held_[at(k)] != 0 && (u == nullptr || std::fabs(u[k]) <= most)) held_[at(k)] = 0, any = true;
      return false;
    });
    return any;
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  template <class F>
  bool any_dof(int island, F f) const {
    for (const int b : tree_.order())
      for (int i = 0; islands_.of(b) == island && i < info(tree_.kind(b)).nv; ++i)
        if (f(b, i)) return true;
    return false;
  }

  const Tree& tree_;
  const Islands& islands_;
  std::vector<char> held_;
};

// The velocities at coordinates q, at which the loops are closed.
std::vector<double> assemble_velocities(const Tree& tree, const Islands& islands, std::span<const char> given, const State& state,
                                        const std::vector<double>& q) {
  std::vector<double> u(state.u().begin(), state.u().end()), open(tree.loops().links.size());
  HeldStart held(tree, islands, given);
  for (bool again = true; again;) {
    const bool holds = held.any();
    const Tree used = holds ? held.tree() : tree;
    Workspace<double> workspace(used);
    load_turns(used, state, workspace);
    std::vector<double> followed = q;
    follow_leaders(used, tree.loops().size(), followed.data(), u.data());
    close_loop_velocities(used, state.time(), q.data(), u.data(), workspace, open);
    again = false;
    const double fast = largest(u);
    std::vector<int> seen;  // islands
    for (std::size_t i = 0; holds && i < open.size(); ++i) {
      const int island = islands.of(end_of_link(tree, i));
      if (open[i] <= left_as_given * fast || std::ranges::find(seen, island) != seen.end()) continue;
      seen.push_back(island);
      const bool zeros = held.release(island, state.u().data(), left_as_given * largest(state.u()));  // momenta have round-off
      if (!zeros && !held.release(island)) continue;
      copy_island(tree, islands, island, state.u(), false, u);  // not what this attempt made of them
      again = true;
    }
  }
  return u;
}

// The mistake if the assembly moved a joint beyond its hard stop.
std::optional<Error> moved_beyond_stops(const Tree& tree, const Names& names, std::span<const double> from,
                                        const std::vector<double>& to) {
  for (const int b : tree.order()) {
    const JointParameters* const p = tree.parameters(b);
    if (p == nullptr || !p->limits.hard() || tree.link(b).driven != 0) continue;
    for (int i = 0; i < info(tree.kind(b)).nv; ++i) {
      const auto k = static_cast<std::size_t>(tree.first_q(b) + i);
      const double low = p->limits.lower_of(i), high = p->limits.upper_of(i);
      // It may have been beyond: an event can give it such a stop.
      if (to[k] >= std::min(low, from[k]) - closed_at_start && to[k] <= std::max(high, from[k]) + closed_at_start) continue;
      return Error("it starts beyond its limits, at " + short_text(to[k]) + ", where loops or couplings put it",
                   "joint '" + names.joint(tree.joint_of(b)) + "'",
                   "give another joint of the loop or coupling a start that keeps this one within its limits");
    }
  }
  return std::nullopt;
}

// Of a state in momenta: by its velocities. It keeps its momenta if nothing had to be closed.
std::optional<Error> assemble_momenta(const Tree& tree, const Model& model, const Names& names, State& state,
                                      const GivenStart& given) {
  Workspace<double> workspace(tree);
  evaluate_rates<double>(tree, state.q().data(), state.p().data(), workspace);
  const std::span<const double> v(workspace.v.get(), state.p().size());
  State closed(tree, Variables::velocities);
  closed.assign(state.time(), state.q(), v, tree);
  closed.set_turns(state.turns());
  std::optional<Error> error = assemble(tree, model, names, closed, given);
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

GivenStart given_start(const Model& model, const Tree& tree) {
  GivenStart given{std::vector<char>(static_cast<std::size_t>(tree.nv())),
                   std::vector<char>(static_cast<std::size_t>(tree.nv()))};
  for (const int b : tree.order()) {
    const int joint = tree.joint_of(b), first = tree.first_p(b), count = info(tree.kind(b)).nv;
    if (joint >= model.size() || model[BodyId{joint}].joint.kind != tree.kind(b)) continue;  // not as declared
    std::fill_n(given.q.begin() + first, count, !model[BodyId{joint}].q.empty());
    std::fill_n(given.v.begin() + first, count, !model[BodyId{joint}].v.empty());
  }
  return given;
}

std::optional<Error> assemble(const Tree& tree, const Model& model, const Names& names, State& state, const GivenStart& given) {
  if (state.variables() == Variables::momenta) return assemble_momenta(tree, model, names, state, given);
  Workspace<double> workspace(tree);
  std::vector<double> residuals(tree.loops().links.size());
  load_turns(tree, state, workspace);
  loop_residuals(tree, state.time(), state.q().data(), state.u().data(), workspace, residuals.data());
  const std::size_t loops = tree.loops().size();
  const auto where = [&](std::size_t i) {
    if (i < loops) return "loop '" + names.joint(tree.loops()[i].id().index) + "'";
    const Coupling& coupling = tree.couplings()[static_cast<std::size_t>(tree.loops().links[i].ends.coupling)];
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
  // Near singular positions a run leaves open what its dependent rows would need.
  const double left = given.by_run ? detail::nearly_closed : left_as_given;
  const double left_fast = given.by_run ? std::sqrt(detail::rank_tolerance) : left_as_given;
  if (worst <= left && loop_velocities_open(tree, workspace) <= left_fast * largest(state.u())) return std::nullopt;
  std::vector<double> sizes;  // of the loops at the start
  for (const LoopPlace& place : workspace.loops->places) sizes.push_back(place.size);
  const Islands islands(tree);
  const auto island = [&](std::size_t link) { return islands.of(end_of_link(tree, link)); };
  HeldStart held(tree, islands, given.q);
  for (std::size_t i = 0; i < residuals.size(); ++i)
    if (!(residuals[i] <= left_as_given) && held.holds_all(island(i))) held.release(island(i));
  std::vector<double> q(state.q().begin(), state.q().end()), u;
  std::vector<Turns> turns;
  for (bool again = false;; again = true) {
    const bool holds = held.any();
    const Tree used = holds ? held.tree() : tree;
    workspace = Workspace<double>(used);
    load_turns(used, state, workspace);
    u.assign(state.u().begin(), state.u().end());
    follow_leaders(used, loops, q.data(), u.data());
    const bool closed = assemble_loops(used, state.time(), q.data(), u.data(), workspace, residuals.data());
    turns = workspace.loops->turns;
    if (holds) loop_residuals(used, state.time(), q.data(), u.data(), workspace, residuals.data());
    bool released = false;
    std::optional<std::size_t> flipped;
    double most = 0;  // of islands that hold values
    for (std::size_t i = 0; i < residuals.size(); ++i)
      if (held.holds(island(i))) most = std::max(most, residuals[i]);
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const bool flips = closed && i < loops && loop_flipped(used, workspace, static_cast<int>(i));
      if (flips && !flipped) flipped = i;
      // What keeps one island open may have kept others from closing.
      if (!flips && residuals[i] < (closed ? left_as_given : std::max(most, detail::nearly_closed))) continue;
      released = held.release(island(i)) || released;
      // The others stay near to what is meant if what is given contradicts itself by little.
      const double grown = i < loops && sizes[i] > 0 ? std::max(1.0, workspace.loops->places[i].size / sizes[i]) : 1;
      if (flips || !(residuals[i] * grown <= rounded_start)) copy_island(tree, islands, island(i), state.q(), true, q);
    }
    if (released) continue;
    if (flipped)
      return Error("it closes only with its axes in opposite directions", where(*flipped),
                   "turn one of its frames by half a turn, or give start values nearer to the intended position");
    if (closed && again) {  // attempts that failed may have moved joints without need
      const Tree all = HeldStart(tree, islands, given.q).tree();
      std::vector<double> start(state.q().begin(), state.q().end());
      follow_leaders(all, loops, start.data(), u.data());
      Workspace<double> own(all);
      load_turns(all, state, own);
      own.loops->turns = turns;
      move_loops_towards(all, state.time(), start.data(), q.data(), own);
      turns = own.loops->turns;
    }
    if (closed) break;
    if (std::optional<Error> error = conflicting_motions(tree, names, state)) return error;
    const auto i = static_cast<std::size_t>(std::max_element(residuals.begin(), residuals.end()) - residuals.begin());
    if (i >= loops)
      return Error(
          "it can't hold from these start values: it stays open by " + apart(i), where(i),
          "it contradicts other couplings, loops, locks or prescribed motions: leave one of them out, or correct its numbers");
    return Error("it can't be closed from these start values: it stays open by " + apart(i), where(i),
                 "check its bodies, 'at', 'child_at' and axes, or give start values nearer to a closed position");
  }
  if (std::optional<Error> error = moved_beyond_stops(tree, names, state.q(), q)) return error;
  state.set_turns(turns);
  u = assemble_velocities(tree, islands, given.v, state, q);
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
  if (!has_equations(model)) return std::nullopt;
  const Tree& tree = model.compiled();
  State state = start_state(model, tree, Variables::velocities);
  const Names names(model);
  if (std::optional<Error> error = assemble(tree, model, names, state, given_start(model, tree))) return error;
  if (std::optional<Error> error = conflicting_motions(tree, names, state)) return error;
  return beyond_stops(tree, names, state);
}

}  // namespace momentree
