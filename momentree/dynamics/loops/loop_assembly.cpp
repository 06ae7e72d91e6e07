// Closing loops at the start, from coordinates that may be far off.
//
// The first attempt makes the change that is least in the metric of the mass matrix. This metric prefers to move the light end of
// a long chain and folds it up. The others use the metric of equal armatures, which spreads the change over all joints, and
// damped steps (Levenberg-Marquardt), which make progress where rows become dependent. Where the residual is least but not zero,
// as in bars that lie in one line, an attempt starts again from disturbed coordinates. What such an attempt moved without need is
// moved back.
#include <algorithm>
#include <cmath>

#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

namespace {

using detail::LoopCorrection, detail::nearly_closed, detail::most_open, detail::open_by;

constexpr int most_steps = 200, disturbed_attempts = 8, most_steps_back = 20;
constexpr double longest_step = 0.5;  // rad, and of the size of the loops

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Start {
  const Tree& tree;
  const double* u;
  double size;                         // of the loops (m)
  std::vector<double> from{}, step{};  // scratch

  // Moves q along `step`, but no joint by more than the longest step.
  double bound() const {
    double largest = 0;
    for (const int b : tree.order())
      for (int i = 0; i < info(tree.kind(b)).nv; ++i) {
        const double change = std::fabs(step[at(tree.first_p(b) + i)]);
        largest = std::max(largest, info(tree.kind(b)).v_units[i] == 'm' ? change / size : change);
      }
    return largest > longest_step ? longest_step / largest : 1;
  }
  void keep(const double* q, const Workspace<double>& workspace) {
    from.assign(q, q + tree.nq());
    step.assign(workspace.a.get(), workspace.a.get() + tree.nv());
  }
  void move(double scale, double* q) const {
    std::copy(from.begin(), from.end(), q);
    detail::displace(tree, step.data(), scale, q);
  }
};

// Newton steps in the metric of the mass matrix; returns how far the loops are open.
double close_by_mass(Start& start, double* q, Workspace<double>& workspace) {
  constexpr double pivots = 1e-6;  // while coordinates are far off
  LoopCorrection correction{start.tree, workspace};
  const LoopWorkspace& loops = *workspace.loops;
  correction.evaluate(q, start.u, pivots);
  double open = most_open(start.tree, loops);
  for (int k = 0; open > nearly_closed && k < most_steps; ++k) {
    correction.solve(q, [&](std::size_t row) { return -loops.rows[row].residual; });
    start.keep(q, workspace);
    bool better = false;
    for (double scale = start.bound(); scale > 1e-6 && !better; scale /= 2) {
      start.move(scale, q);
      correction.evaluate(q, start.u, open < 1e-4 ? 0 : pivots);
      const double now = most_open(start.tree, loops);
      if (now < open * (1 - 1e-4 * scale)) open = now, better = true;
    }
    if (!better) {
      std::copy(start.from.begin(), start.from.end(), q);
      break;
    }
  }
  return open;
}

// Σ (residual / size of the row)².
double squares(const Tree& tree, const LoopWorkspace& loops) {
  double sum = 0;
  for (std::size_t link = 0; link < tree.loops().links.size(); ++link)
    for (int i = 0; i < tree.loops().links[link].rows; ++i) {
      const double r = loops.rows[at(tree.loops().links[link].first_row + i)].residual / detail::row_size(tree, loops, link, i);
      sum += r * r;
    }
  return sum;
}

// Damped steps; returns how far the loops are open.
double close_damped(Start& start, double* q, Workspace<double>& workspace) {
  constexpr double least_damping = 1e-12, most_damping = 1e4, progress = 1e-6;
  LoopCorrection correction{start.tree, workspace};
  const LoopWorkspace& loops = *workspace.loops;
  double damping = 1e-3;
  int slow = 0;
  for (int k = 0; k < most_steps; ++k) {
    correction.evaluate_damped(q, start.u, damping);
    const double open = most_open(start.tree, loops), now = squares(start.tree, loops);
    if (!(open > 0.01 * nearly_closed)) return open;
    correction.solve(q, [&](std::size_t row) { return -loops.rows[row].residual; });
    start.keep(q, workspace);
    start.move(start.bound(), q);
    correction.evaluate_damped(q, start.u, damping);
    const double then = squares(start.tree, loops);
    if (then < now) {
      damping = std::max(damping / 5, least_damping);
      slow = then > (1 - progress) * now ? slow + 1 : 0;
      detail::note_turns(start.tree, workspace);
    } else {
      std::copy(start.from.begin(), start.from.end(), q);
      damping *= 4;
    }
    if (slow > 3 || damping > most_damping) break;
  }
  correction.evaluate_damped(q, start.u, damping);
  return most_open(start.tree, loops);
}

// The same tree, in whose mass matrix all DoFs weigh about the same.
Tree with_equal_armatures(const Tree& tree, double size) {
  double mass = 0;
  for (const int b : tree.order()) mass += tree.link(b).body.m;
  Tree equal = tree;
  for (const int b : tree.order()) {
    const KindInfo& kind = info(tree.kind(b));
    if (kind.nv == 0 || kind.kind == Kind::free) continue;
    JointParameters parameters = tree.parameters(b) != nullptr ? *tree.parameters(b) : JointParameters{};
    parameters.armature = {};
    for (int i = 0; i < kind.nv; ++i) parameters.armature.push_back(kind.v_units[i] == 'm' ? mass : mass * size * size);
    equal.edit().set_parameters(b, parameters);
  }
  return equal;
}

// Moves all DoFs that are not locked by at most `by`, without pattern: the multiples of the golden ratio modulo 1.
void disturb(const Start& start, double by, int attempt, double* q) {
  std::vector<double> change(at(start.tree.nv()));
  for (const int b : start.tree.order())
    for (int i = 0; i < info(start.tree.kind(b)).nv; ++i) {
      const int place = start.tree.first_p(b) + i;
      const double turns = 0.6180339887498949 * (start.tree.nv() * attempt + place);
      const double size = info(start.tree.kind(b)).v_units[i] == 'm' ? start.size : 1;
      if ((start.tree.link(b).locked >> i & 1u) == 0) change[at(place)] = by * size * (2 * (turns - std::floor(turns)) - 1);
    }
  detail::displace(start.tree, change.data(), 1, q);
}

// The motion δ from q towards `to`, from the first order of q + N(q) δ; zero along DoFs that are locked.
void find_motion_towards(const Tree& tree, const double* q, const std::vector<double>& to, std::vector<double>& delta) {
  delta.assign(at(tree.nv()), 0.0);
  for (const int b : tree.order())
    dispatch(tree.kind(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (K::info.nv > 0) {
        const double* const own = q + tree.first_q(b);
        const double* const end = to.data() + tree.first_q(b);
        double change[7] = {}, along = 0;
        const auto quaternion = [](int i) { return K::info.q_units[i] == 'n'; };
        for (int i = 0; i < K::info.nq; ++i) along += quaternion(i) ? own[i] * end[i] : 0;
        for (int i = 0; i < K::info.nq; ++i)  // a quaternion and its negative are one rotation
          change[i] = (quaternion(i) && along < 0 ? -end[i] : end[i]) - own[i];
        for (int i = 0; i < K::info.nv; ++i) {
          if ((tree.link(b).locked >> i & 1u) != 0) continue;
          double unit[6] = {}, rate[7] = {}, product = 0, square = 0;  // the columns of N are orthogonal
          unit[i] = 1;
          K::Kernels::template coordinate_rate<double>(own, unit, rate);
          for (int k = 0; k < K::info.nq; ++k) product += rate[k] * change[k], square += rate[k] * rate[k];
          delta[at(tree.first_p(b) + i)] = product / square;
        }
      }
    });
}

// The square of a motion in the metric of the mass matrix.
double square_of(const Tree& tree, const double* q, const std::vector<double>& motion, Workspace<double>& workspace) {
  sweep_velocities<double, true>(tree, q, motion.data(), workspace);
  double sum = 0;
  for (const int b : tree.order()) {
    const Motion<double>& velocity = workspace.motions[at(b)].velocity;
    sum += dot(velocity, momentum(tree.link(b).body, velocity));
  }
  for (int i = 0; i < tree.nv(); ++i) sum += tree.tables().armature[i] * motion[at(i)] * motion[at(i)];
  return sum;
}

bool flipped(const Tree& tree, const Workspace<double>& workspace) {
  for (std::size_t i = 0; i < tree.loops().size(); ++i)
    if (loop_flipped(tree, workspace, static_cast<int>(i))) return true;
  return false;
}

double size_of(const LoopWorkspace& loops) {
  double size = 0;
  for (const LoopPlace& place : loops.places) size = std::max(size, place.size);
  return size > 0 ? size : 1;
}

// Sets each coordinate to its given value if that leaves the loops open by `most` at most.
void set_back(const Tree& tree, const std::vector<double>& given, double most, double* q, Workspace<double>& workspace) {
  const std::vector<double> rest(at(tree.nv()), 0.0);
  const std::vector<Turns> turns = workspace.loops->turns;
  const auto open_at = [&] {
    sweep_velocities<double, true>(tree, q, rest.data(), workspace);
    detail::place_loops(tree, q, workspace, true);
    return most_open(tree, *workspace.loops);
  };
  double kept[4] = {};
  for (const int b : tree.order()) {
    const KindInfo& kind = info(tree.kind(b));
    for (int i = 0, count = 1; i < kind.nq; i += count) {
      count = kind.q_units[i] == 'n' ? 4 : 1;  // a quaternion as a whole
      if ((kind.nq == kind.nv ? tree.link(b).locked >> i & 1u : tree.link(b).locked) != 0) continue;
      double* const own = q + tree.first_q(b) + i;
      const double* const to = given.data() + tree.first_q(b) + i;
      if (std::equal(own, own + count, to)) continue;
      std::copy_n(own, count, kept);
      std::copy_n(to, count, own);
      if (open_at() <= most && !flipped(tree, workspace)) continue;
      std::copy_n(kept, count, own);
      workspace.loops->turns = turns;
    }
  }
}

// Moves closed loops towards `given` as far as they stay closed and get nearer to it.
void move_back(Start& start, const std::vector<double>& given, double* q, Workspace<double>& workspace) {
  constexpr double near = 1e-12, nearer = 1e-6, shortest = 1e-3;
  LoopCorrection correction{start.tree, workspace};
  const LoopWorkspace& loops = *workspace.loops;
  const std::vector<double> rest(at(start.tree.nv()), 0.0);
  std::vector<double> motion, open, along, kept(q, q + start.tree.nq());
  std::vector<Turns> turns = loops.turns;
  find_motion_towards(start.tree, q, given, motion);
  for (int k = 0; k < most_steps_back; ++k) {
    const double before = square_of(start.tree, q, motion, workspace);
    correction.evaluate(q, rest.data(), 0);
    open.clear();  // the speeds of prescribed motions
    for (const LoopRow& row : loops.rows) open.push_back(row.velocity);
    correction.evaluate(q, motion.data(), 0);
    correction.solve(q, [&](std::size_t row) { return open[row] - loops.rows[row].velocity; });
    for (std::size_t i = 0; i < motion.size(); ++i) motion[i] += workspace.a[i];
    along = motion;
    if (!(square_of(start.tree, q, along, workspace) > near * before)) return;
    bool better = false;
    for (double scale = 1; scale > shortest && !better; scale /= 4) {
      start.from = kept, start.step = along;
      start.move(scale, q);
      better = close_damped(start, q, workspace) <= nearly_closed && !flipped(start.tree, workspace);
      find_motion_towards(start.tree, q, given, motion);
      better = better && square_of(start.tree, q, motion, workspace) < (1 - nearer) * before;
      if (better) break;
      std::copy(kept.begin(), kept.end(), q);
      workspace.loops->turns = turns;
    }
    if (!better) return;
    kept.assign(q, q + start.tree.nq()), turns = loops.turns;
  }
}

}  // namespace

bool assemble_loops(const Tree& tree, double t, double* q, double* u, Workspace<double>& workspace, double* residuals) noexcept {
  LoopWorkspace& loops = detail::loop_memory(tree, workspace);
  detail::set_loop_motions(tree, t, workspace);
  const std::vector<Turns> turns = loops.turns;
  const std::vector<double> given(q, q + tree.nq());
  Start start{tree, u, 0};
  double energy = 0;
  const auto finish = [&] {
    detail::note_turns(tree, workspace);
    return close_loops(tree, t, q, u, workspace, energy);
  };
  const auto report = [&] {
    for (std::size_t i = 0; i < tree.loops().links.size(); ++i) residuals[i] = open_by(tree, loops, i);
  };
  sweep_velocities<double, true>(tree, q, u, workspace);
  detail::place_loops(tree, q, workspace, true);
  start.size = size_of(loops);

  double least = close_by_mass(start, q, workspace);
  report();
  std::vector<double> best(q, q + tree.nq());
  std::vector<Turns> best_turns = loops.turns;
  bool closed = least <= nearly_closed;
  if (closed && !flipped(tree, workspace)) return finish();

  const Tree equal = with_equal_armatures(tree, start.size);
  Workspace<double> other(equal);
  for (int k = 0; k <= disturbed_attempts; ++k) {
    detail::loop_memory(equal, other).turns = turns;
    detail::set_loop_motions(equal, t, other);
    std::copy(given.begin(), given.end(), q);
    Start attempt{equal, u, start.size};
    if (k > 0) disturb(attempt, 0.02 * std::exp2(0.5 * k), k, q);
    const double open = close_damped(attempt, q, other);
    if (!(open < least) && !(open <= nearly_closed)) continue;
    const bool turned = open <= nearly_closed && flipped(equal, other);
    if (closed && turned) continue;
    least = open, closed = open <= nearly_closed;
    best.assign(q, q + tree.nq()), best_turns = other.loops->turns;
    for (std::size_t i = 0; i < tree.loops().links.size(); ++i) residuals[i] = open_by(equal, *other.loops, i);
    if (closed && !turned) break;
  }
  std::copy(best.begin(), best.end(), q);
  loops.turns = best_turns;
  if (!closed) return false;
  move_loops_towards(tree, t, given.data(), q, workspace);
  sweep_velocities<double, true>(tree, q, u, workspace);
  detail::place_loops(tree, q, workspace, true);
  return finish();
}

void move_loops_towards(const Tree& tree, double t, const double* other, double* q, Workspace<double>& workspace) noexcept {
  const std::vector<double> to(other, other + tree.nq()), rest(at(tree.nv()), 0.0);
  LoopWorkspace& loops = detail::loop_memory(tree, workspace);
  detail::set_loop_motions(tree, t, workspace);
  sweep_velocities<double, true>(tree, q, rest.data(), workspace);
  detail::place_loops(tree, q, workspace, true);
  const Tree equal = with_equal_armatures(tree, size_of(loops));
  Workspace<double> own(equal);
  detail::loop_memory(equal, own).turns = loops.turns;
  detail::set_loop_motions(equal, t, own);
  Start start{equal, rest.data(), size_of(loops)};
  set_back(equal, to, nearly_closed, q, own);  // from far off, motions that are least in the metric at q don't lead there
  move_back(start, to, q, own);
  std::vector<double> u = rest;
  double energy = 0;
  if (close_loops(equal, t, q, u.data(), own, energy)) set_back(equal, to, most_open(equal, *own.loops) + 1e-11, q, own);
  loops.turns = own.loops->turns;
  u = rest;
  static_cast<void>(close_loops(tree, t, q, u.data(), workspace, energy));  // to the last digits
}

}  // namespace momentree
