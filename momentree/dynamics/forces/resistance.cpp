#include <momentree/dynamics/forces/resistance.hpp>

#include <algorithm>

#include <momentree/dynamics/forces/friction.hpp>
#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/forces/position_control.hpp>
#include <momentree/dynamics/forces/soft_stop.hpp>

namespace momentree {

namespace {

// Calls f(site, dof, its index in arrays packed as p) for every DoF on which something can resist.
template <class F>
void each_resisted(const Tree& tree, double t, const double* q, const double* u, F&& f) noexcept {
  Power none;
  double nothing = 0;
  for (const int b : tree.joints_with().forces) {
    if (tree.parameters(b) == nullptr || tree.link(b).driven != 0) continue;
    forces::Site site = forces::site_of(tree, t, q, u, b, &nothing, none);
    for (int i = 0; i < site.nv; ++i)
      if (site.on(i)) f(site, i, tree.first_p(b) + i);
  }
}

}  // namespace

void joint_damping(const Tree& tree, double* damping) noexcept {
  std::copy_n(tree.tables().damping.data(), tree.nv(), damping);
  clear_driven(tree, damping);
}

void resisting_forces(const Tree& tree, double t, const double* q, const double* u, const Resisting& to) noexcept {
  for (double* values : {to.dissipating, to.giving, to.slope, to.stiffness})
    if (values != nullptr) std::fill_n(values, tree.nv(), 0.0);
  each_resisted(tree, t, q, u, [&](const forces::Site& s, int i, int at) {
    const JointParameters& p = s.parameters;
    const auto add = [&](double* force, forces::Resistance r) {
      force[at] += r.force, to.slope[at] += r.slope;
      if (to.stiffness != nullptr) to.stiffness[at] += r.stiffness;
    };
    if (p.friction.any()) add(to.dissipating, forces::friction(p.friction, i, s.u[i]));
    if (p.limits.soft()) add(to.dissipating, forces::soft_stop(p.limits, i, s.q[i], s.u[i]));
    if (p.drive != nullptr && p.drive->pd.any()) add(to.giving, forces::position_control(p.drive->pd, i, s.t, s.q[i], s.u[i]));
  });
}

void move_point(const Tree& tree, double t, const double* q, const double* u, double* point) noexcept {
  each_resisted(tree, t, q, u, [&](const forces::Site& s, int i, int at) {
    const JointParameters& p = s.parameters;
    const double from = point[at], to = s.u[i];
    point[at] = to;
    if (p.friction.coulomb.of(i) != 0 && from * to < 0) {
      point[at] = 0;
    } else if (p.drive != nullptr && !p.drive->pd.max_effort.empty() && p.drive->pd.kd.of(i) > 0) {
      const JointDrive::Pd& pd = p.drive->pd;
      const double most = pd.max_effort.of(i), before = forces::asked(pd, i, s.t, s.q[i], from),
                   after = forces::asked(pd, i, s.t, s.q[i], to);
      if (std::fabs(before) >= most && std::fabs(after) >= most && before * after < 0) point[at] = from + before / pd.kd.of(i);
    }
  });
}

}  // namespace momentree
