#include <momentree/simulate/singular_start.hpp>

#include <cmath>

#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/math/sine_cosine.hpp>

namespace momentree {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// The numbers of independent rows of the loops, at closed positions.
std::vector<int> ranks(const Tree& tree, double t, const double* q, Workspace<double>& workspace) {
  static_cast<void>(independent_rows(tree, t, q, workspace));
  const std::vector<int>& first = workspace.loops->kept.first_of;
  std::vector<int> counts;
  for (std::size_t i = 0; i < tree.loops().size(); ++i) counts.push_back(first[i + 1] - first[i]);
  return counts;
}

// Moves the DoFs that are neither locked nor driven by up to a hundredth of a radian or of `size` (m), without pattern.
void displace(const Tree& tree, double size, int attempt, std::vector<double>& q) {
  std::vector<double> change(at(tree.nv()));
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i) {
      const int place = tree.first_p(b) + i;
      const double by = info(tree.kind(b)).v_units[i] == 'm' ? 0.01 * size : 0.01;
      if ((tree.link(b).locked >> i & 1u) == 0) change[at(place)] = by * sine_cosine(12.9898 * (place + 1) + 78.233 * attempt).s;
    }
  detail::displace(tree, change.data(), 1, q.data());
}

}  // namespace

std::vector<JointId> singular_loops(const World& world) {
  constexpr int attempts = 3;
  const Tree& tree = world.tree();
  const State& state = world.state();
  if (tree.loops().empty()) return {};
  Workspace<double> workspace(tree);
  load_turns(tree, state, workspace);
  const std::vector<int> here = ranks(tree, state.time(), state.q().data(), workspace);
  double size = 0;
  for (const LoopPlace& place : workspace.loops->places) size = std::max(size, place.size);
  std::vector<int> most = here;
  int total = 0, largest = 0;
  for (const int count : here) total += count;
  largest = total;
  for (int k = 0; k < attempts; ++k) {
    std::vector<double> q(state.q().begin(), state.q().end()), u(at(tree.nv())), residuals(tree.loops().links.size());
    load_turns(tree, state, workspace);
    displace(tree, size, k, q);
    if (!assemble_loops(tree, state.time(), q.data(), u.data(), workspace, residuals.data())) continue;
    const std::vector<int> there = ranks(tree, state.time(), q.data(), workspace);
    int sum = 0;
    for (const int count : there) sum += count;
    if (sum > largest) largest = sum, most = there;
  }
  std::vector<JointId> singular;
  for (std::size_t i = 0; i < here.size(); ++i)
    if (most[i] > here[i]) singular.push_back(tree.loops()[i].id());
  return singular;
}

}  // namespace momentree
