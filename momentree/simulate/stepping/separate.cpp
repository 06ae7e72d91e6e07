#include <momentree/simulate/stepping/separate.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>

namespace momentree {

namespace {

constexpr double exact = 1e-12;       // depths that are left, relative to coordinates
constexpr double rounding = 1e-13;    // of gaps, relative to coordinates: such bodies touch
constexpr double accuracy = 1e-13;    // of the motion, relative to the deepest overlap
constexpr double longest_turn = 0.2;  // of one try (rad): turns are not linear
constexpr double almost = 1e-3;       // of the first depth
constexpr int most_tries_from_start = 30, most_tries = 200;
constexpr int patience = 20;  // tries in which depths have to halve

}  // namespace

std::optional<Error> Separation::error() const {
  if (!left) return std::nullopt;
  if (!left->cable.empty())
    return Error{left->text() + ", and can't be brought together", "", "give it a longer length, or move one of them"};
  char depth[40];
  std::snprintf(depth, sizeof depth, "%.3g m", left->depth);
  return Error{"'" + left->one + "' and '" + left->other + "' can't be pushed apart: they still overlap by " + depth, "",
               "move one of them, or let them pass through each other: [[contact]] with off = true"};
}

// Returns the deepest overlap (m).
double Separator::find_points(double within) {
  const Tree& tree = world_->tree();
  Workspace<double>& workspace = world_->workspace();
  world_->evaluate();
  near_.clear();
  geometry_->stepped.add_near(within, near_);
  if (near_.empty()) return 0;
  accelerate(tree, world_->state(), workspace);
  world_->place(near_, rows_);
  double deepest = 0;
  gaps_.resize(near_.size());
  for (std::size_t i = 0; i < near_.size(); ++i) {
    gaps_[i] = rows_.touches[i].gap;
    deepest = std::max(deepest, -gaps_[i]), size_ = std::max(size_, norm(rows_.touches[i].point));
  }
  for (double& gap : gaps_)
    if (std::fabs(gap) < rounding * size_) gap = 0;
  return deepest;
}

void Separator::add_stops() {
  const Tree& tree = world_->tree();
  const Numbers q = world_->state().q();
  for (const int b : tree.order()) {
    const JointParameters* const p = tree.parameters(b);
    if (p == nullptr || !p->limits.hard()) continue;
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      for (const double sign : {1.0, -1.0}) {
        const double stop = sign > 0 ? p->limits.lower_of(i) : p->limits.upper_of(i);
        if (!std::isfinite(stop)) continue;
        parts_.add_stop(tree, q.data(), world_->workspace(), b, i, sign, many_);
        const double left = sign * (q[static_cast<std::size_t>(tree.first_q(b) + i)] - stop);
        gaps_.push_back((std::fabs(left) < rounding ? 0 : left) - sign * moved_[static_cast<std::size_t>(tree.first_p(b) + i)]);
      }
  }
}

// How far a joint is beyond its stop (rad, m): steps do not lead there, but loops that are closed after them may.
double Separator::beyond_stops() const {
  const Tree& tree = world_->tree();
  double most = 0;
  for (const int b : tree.order()) {
    const JointParameters* const p = tree.parameters(b);
    if (p == nullptr || !p->limits.hard()) continue;
    for (int i = 0; i < info(tree.kind(b)).nv; ++i) {
      const double q = world_->state().q()[static_cast<std::size_t>(tree.first_q(b) + i)];
      most = std::max({most, p->limits.lower_of(i) - q, q - p->limits.upper_of(i)});
    }
  }
  return most;
}

// Finds the next step; returns its size (rad, m). `from_start`: such that the whole motion is the least one.
double Separator::find_step(bool from_start) {
  const Tree& tree = world_->tree();
  const double* const q = world_->q();
  if (!from_start) std::fill(moved_.begin(), moved_.end(), 0.0);
  parts_.begin(tree, many_);
  parts_.add_points(tree, q, world_->workspace(), near_, rows_, many_);
  add_stops();
  sweep_velocities<double, true>(tree, q, moved_.data(), world_->workspace());
  locate_stage(tree, q, world_->workspace());
  place_contacts(tree, world_->workspace(), near_, rows_);
  for (std::size_t i = 0; i < near_.size(); ++i) gaps_[i] -= rows_.velocity[3 * i];  // the gaps at the start
  static_cast<void>(world_->state().edit());  // the workspace no longer holds its evaluation
  step_.assign(moved_.size(), 0.0);
  parts_.add_to(tree, many_, many_.separate(gaps_, pushes_, accuracy), step_.data());
  double largest = 0;
  for (std::size_t i = 0; i < step_.size(); ++i) {
    step_[i] -= moved_[i];
    largest = std::max(largest, std::fabs(step_[i]));
  }
  return std::isfinite(largest) ? largest : 0;
}

void Separator::take_step(double part) {
  const Tree& tree = world_->tree();
  for (std::size_t i = 0; i < step_.size(); ++i) step_[i] *= part, moved_[i] += step_[i];
  const double t = world_->time();
  const State::Edit edit = world_->state().edit();
  displacement_.apply(tree, t, step_.data(), edit.q.data(), edit.u.data(), world_->workspace());
  double ignored = 0;
  if (tree.has_loops()) static_cast<void>(world_->evaluator().close(t, edit.q.data(), edit.u.data(), ignored));
}

// Centres of mass.
std::vector<Vec3> Separator::centres() const {
  std::vector<Vec3> all;
  for (int b = 0; b < world_->model().size(); ++b)
    all.push_back(world_->is_gone(b) ? Vec3{}
                                     : world_->world().motions()[static_cast<std::size_t>(b)].pose * world_->model()[{b}].com);
  return all;
}

// The overlap of the points that were found last.
std::optional<Overlap> Separator::what_is_left() const {
  const auto deepest = std::min_element(gaps_.begin(), gaps_.end());
  if (near_.empty() || !(-*deepest > exact * size_)) return geometry_->overlaps.of_located();
  const Contact& c = near_[static_cast<std::size_t>(deepest - gaps_.begin())];
  return Overlap{world_->name_of(std::max(c.a, c.b)), world_->name_of(std::min(c.a, c.b)), -*deepest,
                 c.cable < 0 ? std::string() : world_->model().springs()[static_cast<std::size_t>(c.cable)].name};
}

Separation Separator::run() {
  Separation result;
  double deepest = find_points(0);
  if (!(deepest > exact * size_)) return result;
  const std::vector<Vec3> before = centres();
  const auto note_displacement = [&] {
    result.largest = 0;
    const std::vector<Vec3> now = centres();
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double by = norm(now[i] - before[i]);
      if (by > result.largest) result.largest = by, result.body = world_->name_of(static_cast<int>(i));
    }
  };
  moved_.assign(static_cast<std::size_t>(world_->tree().nv()), 0.0);
  const double first = deepest;
  double last = HUGE_VAL, looked_at = HUGE_VAL;
  bool from_start = true;
  for (int k = 0, later = 0; k < most_tries; ++k) {
    deepest = find_points(2 * std::max(deepest, result.largest));
    if (!from_start) {
      deepest = std::max(deepest, beyond_stops());
      // Points that are only near may be others than those that overlap.
      if (!(deepest > exact * size_) && !((deepest = find_points(0)) > exact * size_)) break;
      if (later++ % patience == 0 && !(deepest < 0.5 * std::exchange(looked_at, deepest))) break;
    }
    const double size = near_.empty() ? 0 : find_step(from_start);
    if (from_start) {
      // Where the least motion would begin anew elsewhere, this one is good enough.
      const bool elsewhere = deepest < almost * first && size > 2 * last;
      from_start = size > exact * size_ && !elsewhere && k + 1 < most_tries_from_start;
      if (elsewhere) continue;
    }
    if (!(size > 0) && !from_start && later > 0) break;
    if (!(size > 0)) continue;
    take_step(std::min(1.0, std::max(longest_turn, 2 * deepest) / size));
    last = size;
    note_displacement();
  }
  static_cast<void>(find_points(0));
  note_displacement();
  result.left = what_is_left();
  return result;
}

Separation Separator::of(const Model& model) {
  World world(model, Variables::velocities);
  Evaluator evaluator = ContactWorld::evaluator_of(world);
  const ContactGeometry geometry(world, evaluator);
  return geometry.pairs.any() ? Separator(geometry).run() : Separation{};
}

Separation separation_of(const Model& model) { return model.has_contact() ? Separator::of(model) : Separation{}; }

}  // namespace momentree
