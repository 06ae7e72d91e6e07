#include <momentree/simulate/analysis/equilibrium.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/base/error.hpp>
#include <momentree/dynamics/acceleration.hpp>
#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/simulate/analysis/limits.hpp>

namespace momentree {

namespace {

using analysis::Configuration;
using analysis::Held;

using analysis::at;
using analysis::find_held;
using analysis::held_accelerations;

double largest(const std::vector<double>& x) {
  double most = 0;
  for (const double each : x) most = std::max(most, std::fabs(each));
  return most;
}

void require_statics(const World& world) {
  const Tree& tree = world.tree();
  for (const int b : tree.joints_with().motions) {
    const Curve::Point s = prescribed_motion(tree, b).at(world.time());
    if (s.rate != 0 || s.acceleration != 0)
      throw_error({"the prescribed motion of joint '" + std::string(world.joint_name(tree.inboard_joint({b}))) +
                       "' moves it at this time: there is no equilibrium",
                   "", "look for it at a time at which the motion rests, or lock the joint"});
  }
  for (std::size_t i = 0; i < tree.loops().size(); ++i)
    if (tree.loops()[i].driven())
      throw_error({"a joint that closes a loop has a prescribed motion: the equilibrium is not found by this function", "",
                   "put the motion into a joint of the tree, or lock the joint"});
  if (!world.model().colliders().empty())
    throw_error({"the equilibrium of bodies that can touch is not found by this function", "",
                 "run the world with damping until it is at rest, or leave out the collisions"});
  if (!world.tree().contacts().empty())
    throw_error({"a cable is taut since the last run", "",
                 "look for the equilibrium before the run, or after set_state to a place where the cable is slack"});
}

bool exact(const Configuration& at_rest, const Held& held) { return held.limits.empty() && at_rest.exact(); }

/// Slopes of the accelerations along the columns of P; of differences with that width, if they are not exact.
DenseMatrix held_slopes(Configuration& at_rest, const Held& held, double width = 1e-5) {
  if (exact(at_rest, held)) return at_rest.slopes() * held.P;
  return at_rest.differences(
      held.P, [&] { return held_accelerations(at_rest, held); }, width);
}

// With M = L Lᵀ, the modes are the eigenvectors of −Lᵀ (P K P) L⁻ᵀ, which is symmetric.
std::vector<Mode> modes_of(Configuration& at_rest, const Held& held) {
  const int n = at_rest.nv();
  const DenseMatrix &P = held.P, K = held_slopes(at_rest, held), L = cholesky(at_rest.mass());
  DenseMatrix inverse(n, n);  // L⁻ᵀ
  for (int j = 0; j < n; ++j)
    for (int i = n; i-- > 0;) {
      double sum = i == j ? 1 : 0;
      for (int k = i + 1; k < n; ++k) sum -= L(k, i) * inverse(k, j);
      inverse(i, j) = sum / L(i, i);
    }
  DenseMatrix transposed(n, n), S(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) transposed(i, j) = L(j, i);
  const DenseMatrix product = transposed * (P * (K * inverse));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) S(i, j) = -0.5 * (product(i, j) + product(j, i));
  // Displacements that are not allowed are eigenvectors of zero, too. The projection moves them above all others.
  double square = 0;
  for (const double each : S.numbers) square += each * each;
  const double bound = std::sqrt(square), above = 2 * bound + 1;
  const DenseMatrix Q = transposed * (P * inverse);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) S(i, j) += 0.5 * above * ((i == j ? 2 : 0) - Q(i, j) - Q(j, i));
  const SymmetricEigen eigen = symmetric_eigen(S);
  // The error of each mode: of rounding, or of differences, which others with another width show.
  DenseMatrix noise(n, n);
  if (!exact(at_rest, held)) {
    const DenseMatrix other = transposed * (P * (held_slopes(at_rest, held, 3e-5) * inverse));
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) noise(i, j) = 0.5 * (other(i, j) + other(j, i) - product(i, j) - product(j, i));
  }
  std::vector<Mode> modes;
  for (int k = 0; k < n && eigen.values[at(k)] < bound + 0.5; ++k) {
    Mode mode{eigen.values[at(k)], std::vector<double>(at(n))};
    double error = 0;
    for (int i = 0; i < n; ++i) {
      double row = 0;
      for (int j = 0; j < n; ++j) row += noise(i, j) * eigen.vectors(j, k);
      error += row * row;
    }
    if (std::fabs(mode.square) < 1e-12 * bound + 3 * std::sqrt(error)) mode.square = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) mode.shape[at(i)] += inverse(i, j) * eigen.vectors(j, k);
    modes.push_back(std::move(mode));
  }
  return modes;
}

/// Pseudo-transient continuation: implicit Euler steps of the flow q̇ = v̇(q). They grow as the forces vanish, and become steps
/// of Newton's method.
class Search {
 public:
  explicit Search(const World& world) : world_(world), at_(world), gravity_(norm(world.tree().gravity())) {}

  Equilibrium find() {
    constexpr int most = 500;
    if (const int cable = analysis::stretched_cable(at_); cable >= 0)
      throw_error({"cable '" + world_.model().springs()[at(cable)].name + "' is longer than its length", "",
                   "start where it is slack or just taut, or give it another length"});
    Held held;
    std::vector<double> a = forces(held);
    double size = largest(a), best = HUGE_VAL, length = size > 0 ? 0.05 / size : 1;
    const double scale = gravity_ + largest(at_.accelerations());
    int iteration = 0, stalled = 0;
    for (; iteration < most && size > 1e-14 * scale; ++iteration) {
      if (!step(held, a, length)) length *= 0.1;
      a = forces(held);
      const double now = largest(a);
      length = std::min(length * std::clamp(size / std::max(now, 1e-300), 0.2, 10.0), 1e12);
      size = now;
      stalled = size < 0.5 * best ? 0 : stalled + 1;
      best = std::min(best, size);
      if (size <= 1e-9 * scale && stalled >= 3) break;
    }
    if (!(size <= 1e-9 * scale)) refuse(a, iteration);
    Equilibrium found;
    found.q.assign(at_.q().begin(), at_.q().end());
    found.residual = size, found.iterations = iteration;
    for (const analysis::Limit& limit : held.limits) {
      if (limit.dof >= 0) found.resting.push_back(limit.dof);
      if (limit.cable >= 0) found.taut.push_back(limit.cable);
    }
    add_stops_that_hold(found.resting);
    found.modes = modes_of(at_, held);
    return found;
  }

 private:
  // Accelerations at rest, with what stops hold.
  std::vector<double> forces(Held& held) {
    const std::vector<double> a = at_.accelerations();
    held = find_held(at_, a);
    return held.P * a;
  }

  // A DoF that rests on a stop since the last run is locked in the world.
  void add_stops_that_hold(std::vector<int>& resting) {
    const Tree& tree = at_.tree();
    for (const ActiveLimit& limit : world_.constraints().active_limits) {
      if (limit.joint >= tree.bodies())
        throw_error({"joint '" + std::string(world_.joint_name({limit.joint})) + "' closes a loop and rests on its stop", "",
                     "stops of joints that close loops are not covered: move it off the stop, with set_state"});
      double effort[6] = {};
      accelerate(tree, at_.state(), at_.workspace());
      joint_effort(tree, at_.state(), at_.workspace(), {limit.joint}, effort);
      if (limit.sign * effort[limit.dof] > 1e-9 * (1 + std::fabs(effort[limit.dof])))
        throw_error({"joint '" + std::string(world_.joint_name({limit.joint})) + "' would leave the stop on which it rests", "",
                     "move it off the stop, with set_state, and look for the equilibrium from there"});
      resting.push_back(tree.first_p(tree.carrier(limit.joint)) + limit.dof);
    }
    std::sort(resting.begin(), resting.end());
  }

  // (1/length + (1 − P) − P K P) y = a, and a move by P y.
  bool step(const Held& held, const std::vector<double>& a, double length) {
    const int n = at_.nv();
    DenseMatrix system = held.P * held_slopes(at_, held);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) system(i, j) = (i == j ? 1 / length + 1 : 0) - held.P(i, j) - system(i, j);
    std::vector<double> move = held.P * least_squares(system, a, 1e-15);
    const double far = largest(move);
    if (!std::isfinite(far)) return false;
    for (double& each : move) each *= far > 0.3 ? 0.3 / far : 1;
    // As far as the next limit: beyond it, it would no longer be the same mechanism.
    const double part = analysis::part_to_limits(at_, move);
    for (double& each : move) each *= part;
    const std::vector<double> before(at_.q().begin(), at_.q().end());
    if (!at_.displace(move)) return false;
    if (analysis::shorten_cables(at_)) return true;
    static_cast<void>(at_.set(before));  // as closed as it was
    return false;
  }

  [[noreturn]] void refuse(const std::vector<double>& a, int iterations) const {
    const auto worst = static_cast<int>(
        std::max_element(a.begin(), a.end(), [](double x, double y) { return std::fabs(x) < std::fabs(y); }) - a.begin());
    throw_error({"no equilibrium was found: after " + std::to_string(iterations) + " steps joint '" +
                     std::string(world_.joint_name(joint_of_dof(at_.tree(), worst))) + "' still accelerates",
                 "", "something must hold each body: a joint, a spring, or a stop; or start nearer to the equilibrium"});
  }

  const World& world_;
  Configuration at_;
  double gravity_;
};

}  // namespace

double Mode::frequency() const { return square > 0 ? std::sqrt(square) / (2 * std::acos(-1.0)) : 0; }

bool Equilibrium::stable() const {
  return std::all_of(modes.begin(), modes.end(), [](const Mode& mode) { return mode.square >= 0; });
}

JointId joint_of_dof(const Tree& tree, int dof) {
  for (const int b : tree.order())
    if (dof >= tree.first_p(b) && dof < tree.first_p(b) + info(tree.kind(b)).nv) return tree.inboard_joint({b});
  MT_REQUIRE(false, "a place in v");
  return {};
}

Equilibrium equilibrium(const World& world) {
  require_statics(world);
  return Search(world).find();
}

}  // namespace momentree
