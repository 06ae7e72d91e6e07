#include <momentree/tree/packed.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <momentree/base/error.hpp>
#include <momentree/joint/link_constants.hpp>
#include <momentree/math/unit.hpp>

namespace momentree {

namespace {

std::string text(double x) {
  char number[32];
  std::snprintf(number, sizeof number, "%.9g", x);
  return number;
}

int first_quaternion(const KindInfo& kind) {
  for (int i = 0; i < kind.nq; ++i)
    if (kind.q_units[i] == 'n') return i;
  return -1;
}

}  // namespace

void check_packed(const Tree& tree, const char* what, bool coordinates, std::span<const double> all, const JointNamer& name) {
  const auto size = static_cast<std::size_t>(coordinates ? tree.nq() : tree.nv());
  if (all.size() != size)
    throw_error({std::to_string(all.size()) + " " + what + " were given, but the joints have " + std::to_string(size), "",
                 "give the numbers of all joints, in the order of their numbers"});
  const auto finite = [](double x) { return std::isfinite(x); };
  if (std::all_of(all.begin(), all.end(), finite)) return;
  for (const int b : tree.order()) {
    const int first = coordinates ? tree.first_q(b) : tree.first_p(b);
    const int count = coordinates ? info(tree.kind(b)).nq : info(tree.kind(b)).nv;
    for (int i = 0; i < count; ++i) {
      const double x = all[static_cast<std::size_t>(first + i)];
      if (finite(x)) continue;
      throw_error(
          {"number " + std::to_string(first + i) + " of the " + what + " is " + (std::isnan(x) ? "not a number" : text(x)),
           "joint '" + name(tree.joint_of(b)) + "'", "give finite numbers"});
    }
  }
}

void check_limits(const Tree& tree, std::span<const double> q, const JointNamer& name) {
  constexpr double tolerance = 1e-6;
  for (const int b : tree.order()) {
    const JointParameters* const p = tree.parameters(b);
    if (p == nullptr || !p->limits.hard() || tree.link(b).driven != 0) continue;
    for (int i = 0; i < info(tree.kind(b)).nv; ++i) {
      const double x = q[static_cast<std::size_t>(tree.first_q(b) + i)], low = p->limits.lower_of(i),
                   high = p->limits.upper_of(i);
      const bool below = x<low - tolerance*(1 + std::fabs(low)), above = x> high + tolerance * (1 + std::fabs(high));
      if (below || above)
        throw_error({"the coordinate " + text(x) + " is beyond the stop at " + text(below ? low : high),
                     "joint '" + name(tree.joint_of(b)) + "'", "hard stops hold coordinates between them"});
    }
  }
}

void normalise_quaternions(const Tree& tree, std::span<double> q, const JointNamer& name) {
  for (const int b : tree.joints_with().quaternions) {
    const int first = first_quaternion(info(tree.kind(b)));
    double* const at = q.data() + tree.first_q(b) + first;
    const double length = std::hypot(std::hypot(at[0], at[1]), std::hypot(at[2], at[3]));
    if (!(std::fabs(length - 1) <= 1e-6))
      throw_error({"a quaternion has the length " + text(length), "joint '" + name(tree.joint_of(b)) + "'",
                   "quaternions (w, x, y, z) have the length 1"});
    const Quat u = unit(Quat{at[0], at[1], at[2], at[3]});
    at[0] = u.w, at[1] = u.x, at[2] = u.y, at[3] = u.z;
  }
}

void clear_locked(const Tree& tree, double* p) noexcept {
  for (const int b : tree.order()) {
    const unsigned locked = tree.joint(b).locked;
    for (int i = 0; locked != 0 && i < info(tree.kind(b)).nv; ++i)
      if ((locked >> i & 1u) != 0) p[tree.first_p(b) + i] = 0;
  }
}

}  // namespace momentree
