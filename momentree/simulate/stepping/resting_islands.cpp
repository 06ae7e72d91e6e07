#include <momentree/simulate/stepping/resting_islands.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/loops/islands.hpp>
#include <momentree/simulate/contact/contact_policy.hpp>
#include <momentree/simulate/stepping/stepped_pairs.hpp>

namespace momentree {

namespace {

std::size_t place(int body) { return static_cast<std::size_t>(body); }

bool all_within(const Tree& tree, int body, const auto& of, double most) {
  for (int i = tree.first_p(body), end = i + info(tree.kind(body)).nv; i < end; ++i)
    if (!(std::fabs(of[place(i)]) <= most)) return false;
  return true;
}

// What is true of all bodies of an island, by its number.
std::vector<bool> true_of_all(const Tree& tree, const Islands& islands, const std::vector<bool>& bodies) {
  std::vector<bool> all(bodies.size(), true);
  for (const int b : tree.order())
    if (!bodies[place(b)]) all[place(islands.of(b))] = false;
  return all;
}

// By number of an island: a contact carries it.
std::vector<bool> carried(const Tree& tree, const Islands& islands, std::span<const SteppedContact> points) {
  std::vector<bool> all(place(tree.bodies()), false);
  for (const SteppedContact& point : points)
    for (const int body : {point.a, point.b})
      if (point.joint < 0 && body >= 0) all[place(islands.of(body))] = true;
  return all;
}

}  // namespace

// Bodies whose joints have no parameters with an effect, and on which no forces and springs act.
void RestingIslands::find_loose(const Tree& tree) {
  loose_.assign(place(tree.bodies()), false);
  for (const int b : tree.order()) loose_[place(b)] = tree.parameters(b) == nullptr || !tree.parameters(b)->any();
  for (const int b : tree.loads().bodies) loose_[place(b)] = false;
}

void RestingIslands::begin_step(const Tree& tree, const State& state, Workspace<double>& workspace,
                                std::span<const SteppedContact> points, double usual_step) {
  q_.assign(state.q().begin(), state.q().end()), u_.assign(state.u().begin(), state.u().end());
  rests_.clear(), loose_.clear();
  if (tree.has_loops()) return;
  find_loose(tree);
  if (points.empty()) return;
  for (const SteppedContact& point : points)  // on a belt, which does work
    for (const int body : {point.a, point.b})
      if (body >= 0 && norm(point.slip) > policy::step_slip) loose_[place(body)] = false;
  const auto stands = [&](int b) { return loose_[place(b)] && all_within(tree, b, u_, 0); };
  if (std::ranges::none_of(tree.order(), stands)) return;
  accelerate(tree, state, workspace);
  rests_.assign(place(tree.bodies()), false);
  for (const int b : tree.order())
    rests_[place(b)] = stands(b) && all_within(tree, b, workspace.a, policy::standing_still / usual_step);
}

bool RestingIslands::put_back(const Tree& tree, State& state, const SteppedPairs& pairs, double within,
                              std::span<const SteppedContact> points) {
  stays_.clear();
  if (rests_.empty()) return false;
  Islands islands(tree);
  pairs.join_near(within, islands);
  for (const SteppedContact& point : points) islands.join(point.a, point.b);
  const std::vector<bool> rest = true_of_all(tree, islands, rests_), held = carried(tree, islands, points);
  stays_.assign(rests_.size(), false);
  const State::Edit edit = state.edit();
  bool any = false;
  for (const int b : tree.order()) {
    const std::size_t island = place(islands.of(b));
    if (!rest[island] || !held[island]) continue;
    any = stays_[place(b)] = true;
    std::copy_n(q_.begin() + tree.first_q(b), info(tree.kind(b)).nq, edit.q.begin() + tree.first_q(b));
    std::copy_n(u_.begin() + tree.first_p(b), info(tree.kind(b)).nv, edit.u.begin() + tree.first_p(b));
  }
  return any;
}

void RestingIslands::come_to_rest(const Tree& tree, State& state, std::span<const SteppedContact> points) {
  if (points.empty() || loose_.empty() || u_.size() != state.u().size()) return;
  std::vector<bool> slow(loose_.size(), false);
  bool any = false;
  for (const int b : tree.order()) {
    slow[place(b)] = loose_[place(b)] && all_within(tree, b, u_, policy::standing_still) &&
                     all_within(tree, b, state.u(), policy::standing_still);
    any = any || slow[place(b)];
  }
  if (!any) return;
  const Islands mechanisms(tree);
  const std::vector<bool> rest = true_of_all(tree, mechanisms, slow), held = carried(tree, mechanisms, points);
  const State::Edit edit = state.edit();
  for (const int b : tree.order())
    if (const std::size_t mechanism = place(mechanisms.of(b)); rest[mechanism] && held[mechanism])
      std::fill_n(edit.u.begin() + tree.first_p(b), info(tree.kind(b)).nv, 0.0);
}

}  // namespace momentree
