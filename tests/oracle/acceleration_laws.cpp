#include <tests/oracle/laws.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <tests/oracle/kinematics.hpp>

namespace momentree::oracle {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

double narrow(Real x) { return static_cast<double>(x); }
Real length(const V3<Real>& a) { return std::sqrt(dot(a, a)); }
Real length(const std::array<Real, 6>& e, unsigned from) { return length(V3<Real>{{e[from], e[from + 1], e[from + 2]}}); }

/// The tree's joint at its present coordinates, separately.
struct Alone {
  System system;
  std::vector<double> q;
  std::vector<Real> v;
};
Alone joint_alone(const Tree& tree, const State& state, const Workspace<double>& workspace, int b) {
  const Joint& joint = tree.joint(b);
  Alone one;
  JointSpec spec;
  spec.kind = joint.kind, spec.axis = joint.axis, spec.axis2 = joint.axis2, spec.pitch = joint.pitch;
  if (tree.parameters(b)) spec.parameters = *tree.parameters(b);
  one.system.links.push_back({-1, spec, joint.at, joint.child_at, 1, {}, {}});
  number(one.system);
  one.system.time = state.time();
  for (int i = 0; i < one.system.nq(); ++i) one.q.push_back(state.q()[static_cast<std::size_t>(tree.first_q(b) + i)]);
  for (int i = 0; i < one.system.nv(); ++i) one.v.push_back(workspace.v[static_cast<std::size_t>(tree.first_p(b) + i)]);
  return one;
}

int declared_child(const Tree& tree, int b) { return tree.reversed(b) ? tree.parent(b) : b; }
int declared_parent(const Tree& tree, int b) { return tree.reversed(b) ? b : tree.parent(b); }

/// True if the tree's joint of `b` is that of the system: false for the free joint of a body that was not a root.
bool declared(const System& system, const Tree& tree, int b) {
  const Link& link = system.links[static_cast<std::size_t>(declared_child(tree, b))];
  return link.parent == declared_parent(tree, b);
}

}  // namespace

double equations_of_motion(const System& system, const Tree& tree, const State& state, Workspace<double>& workspace,
                           const std::vector<Load>& loads) {
  locate_bodies(tree, state, workspace);
  accelerate(tree, state, workspace);
  const auto n = system.links.size();
  struct Sum {
    V3<Real> force{}, torque{};  ///< about the centre of mass, world axes
    Real force_summands = 0, torque_summands = 0;
  };
  std::vector<Sum> sums(n);
  std::vector<Frame<Real>> frames;
  std::vector<V3<Real>> coms;
  for (std::size_t k = 0; k < n; ++k) {
    const Link& link = system.links[k];
    const Frame<Real> frame = frame_of(user_pose(tree, workspace.bodies[k], static_cast<int>(k)));
    const BodyAcceleration a = body_acceleration(tree, state, workspace, BodyId{static_cast<int>(k)});
    const Sym3& j = link.inertia;
    const M3<Real> inertia =
        frame.rotation * M3<Real>{{j.xx, j.xy, j.xz, j.xy, j.yy, j.yz, j.xz, j.yz, j.zz}} * transposed(frame.rotation);
    const V3<Real> arm = frame.rotation * real(link.com), w = real(workspace.bodies[k].R * workspace.bodies[k].velocity.w);
    const V3<Real> linear = real(a.linear), angular = real(a.angular);
    Sum& s = sums[k];
    const Real m = link.mass;
    s.force = scaled(m, system.gravity - linear - cross(angular, arm) - cross(w, cross(w, arm)));
    s.torque = V3<Real>{} - inertia * angular - cross(w, inertia * w);
    s.force_summands = m * (length(system.gravity) + length(linear) + length(angular) * length(arm) + dot(w, w) * length(arm));
    s.torque_summands = length(inertia * angular) + length(cross(w, inertia * w));
    // The body moves relative to another, whose motion may be much faster.
    if (const int outer = tree.parent(static_cast<int>(k)); outer >= 0) {
      const BodyAcceleration by = body_acceleration(tree, state, workspace, BodyId{outer});
      const Vec3 way = workspace.bodies[k].r - workspace.bodies[static_cast<std::size_t>(outer)].r;
      s.force_summands += m * (length(real(by.linear)) + length(real(by.angular)) * length(real(way)));
      s.torque_summands += length(real(by.angular)) * (j.xx + j.yy + j.zz);
    }
    s.torque_summands += length(arm) * s.force_summands;
    if (!loads.empty()) {
      const Load& load = loads[k];
      s.force = s.force + load.force;
      s.torque = s.torque + load.torque - cross(arm, load.force);
      s.force_summands += length(load.force);
      s.torque_summands += length(load.torque) + length(arm) * length(load.force);
    }
    frames.push_back(frame);
    coms.push_back(frame.position + arm);
  }
  for (int b = 0; b < tree.bodies(); ++b) {
    const Force<double> W = as_force(reaction(tree, state, workspace, tree.inboard_joint({b})));
    const int child = declared_child(tree, b), parent = declared_parent(tree, b);
    const Frame<Real>& at = frames[static_cast<std::size_t>(child)];
    const V3<Real> f = at.rotation * real(W.l), t = at.rotation * real(W.h);
    const auto act = [&](int body, Real sign) {
      if (body < 0) return;
      Sum& s = sums[static_cast<std::size_t>(body)];
      const V3<Real> arm = at.position - coms[static_cast<std::size_t>(body)];
      s.force = s.force + scaled(sign, f);
      s.torque = s.torque + scaled(sign, t + cross(arm, f));
      s.force_summands += length(f);
      s.torque_summands += length(t) + length(arm) * length(f);
    };
    act(child, 1);
    act(parent, -1);
  }
  Real worst = 0;
  for (const Sum& s : sums) {
    if (s.force_summands > 0) worst = std::max(worst, length(s.force) / s.force_summands);
    if (s.torque_summands > 0) worst = std::max(worst, length(s.torque) / s.torque_summands);
    if (std::isnan(length(s.force)) || std::isnan(length(s.torque))) return std::numeric_limits<double>::quiet_NaN();
  }
  return narrow(worst);
}

double work_of_reactions(const Tree& tree, const State& state, Workspace<double>& workspace) {
  accelerate(tree, state, workspace);
  Real worst = 0;
  for (int b = 0; b < tree.bodies(); ++b) {
    // Summands of Tr = Mb Ω̇ + W: the outboard bodies, moving with the body.
    Real felt = length(real(tree.gravity()));
    for (int k = b; k >= 0; k = k == b ? tree.parent(b) : -1) {
      const Motion<double> a = felt_acceleration(tree, state.q().data(), workspace, k);
      felt += length(real(a.v)) + length(real(a.w));
    }
    const Real carried = tree.subtree_mass(b) * felt;
    const Alone one = joint_alone(tree, state, workspace, b);
    const auto E = joint_columns(one.system, one.q, 0);
    const std::vector<Real> force = joint_forces(one.system, one.q, one.v);
    const Force<double> W = as_force(reaction(tree, state, workspace, tree.inboard_joint({b}))),
                        pure = as_force(bearing_reaction(tree, state, workspace, tree.inboard_joint({b})));
    for (std::size_t i = 0; i < E.size(); ++i) {
      const auto& e = E[i];
      const int k = tree.first_p(b) + static_cast<int>(i);
      const Real udot = workspace.a[static_cast<std::size_t>(k)];
      const V3<Real> v{{e[0], e[1], e[2]}}, w{{e[3], e[4], e[5]}};
      if ((tree.joint(b).locked >> i & 1u) != 0) {
        if (udot != 0) return std::numeric_limits<double>::infinity();
        continue;
      }
      const Real along = std::fabs(dot(v, real(pure.l)) + dot(w, real(pure.h)));
      if ((tree.link(b).driven >> i & 1u) != 0) {  // whatever it requires
        const Real summands = length(e, 0) * (length(real(W.l)) + carried) + length(e, 3) * (length(real(W.h)) + carried);
        if (summands > 0) worst = std::max(worst, along / summands);
        continue;
      }
      const Real rotor = tree.tables().armature[k] * udot;
      const Real summands = length(e, 0) * (length(real(W.l)) + carried) + length(e, 3) * (length(real(W.h)) + carried) +
                            std::fabs(force[i]) + std::fabs(rotor);
      if (summands == 0) continue;
      worst = std::max(worst, std::fabs(dot(v, real(W.l)) + dot(w, real(W.h)) - force[i] + rotor) / summands);
      worst = std::max(worst, along / summands);
    }
  }
  return narrow(worst);
}

std::vector<Measure> measure_accelerations(const System& system, const Tree& tree, const State& state,
                                           Workspace<double>& workspace, const Spectrum& range) {
  std::vector<Measure> laws;
  locate_bodies(tree, state, workspace);
  accelerate(tree, state, workspace);
  const int nv = tree.nv();
  const std::vector<double> q(state.q().begin(), state.q().end());
  const std::vector<Real> v(workspace.v.get(), workspace.v.get() + nv);
  std::vector<char> locked(static_cast<std::size_t>(nv), 0);
  std::vector<Real> given(static_cast<std::size_t>(nv), 0);
  bool single_dof = true;
  for (int b = 0; b < tree.bodies(); ++b)
    for (int i = 0; i < dofs(tree.joint(b).kind); ++i) {
      locked[static_cast<std::size_t>(tree.first_p(b) + i)] = (tree.joint(b).locked >> i & 1u) != 0;
      single_dof = single_dof && i == 0;
      if (tree.link(b).driven == 0) continue;
      locked[static_cast<std::size_t>(tree.first_p(b))] = 1;
      given[static_cast<std::size_t>(tree.first_p(b))] =
          signal_at(tree.parameters(b)->drive->motion[0].signal(), state.time()).tt;
    }
  const Accelerations exact = accelerate(system, q, v, mass_matrix(system, q), locked, given);

  const double bound = std::max(single_dof ? 1e-12 : 1e-10, epsilon * range.condition());
  const auto enter = [&laws](const char* law, Real error, Real scale, double within) {
    laws.push_back({law, scale > 0 ? narrow(error / scale) : narrow(error), within});
  };
  // If the forces almost cancel, the rounding error is that of the summands.
  const double by_summands = norm(exact.v) > 0 ? 8 * epsilon * narrow(exact.summands / norm(exact.v)) : bound;
  if (nv > 0)
    enter("dv/dt", distance({workspace.a.get(), workspace.a.get() + nv}, exact.v), norm(exact.v), std::max(bound, by_summands));
  Real linear = 0, angular = 0, force = 0, torque = 0, fast = 0, whirl = 0, most = 0, context = 0, weight = 0;
  for (int b = 0; b < tree.bodies(); ++b) {
    const BodyAcceleration a = body_acceleration(tree, state, workspace, BodyId{b});
    const Accelerations::Body& e = exact.bodies[static_cast<std::size_t>(b)];
    linear = std::max(linear, length(real(a.linear) - e.linear));
    angular = std::max(angular, length(real(a.angular) - e.angular));
    fast = std::max(fast, length(e.linear));
    const V3<Real> w = real(workspace.bodies[static_cast<std::size_t>(b)].velocity.w);
    whirl = std::max(whirl, length(e.angular) + dot(w, w));
    weight = std::max(weight, system.links[static_cast<std::size_t>(b)].mass * length(system.gravity - e.linear));
    if (!declared(system, tree, b)) continue;
    const Accelerations::Body& child = exact.bodies[static_cast<std::size_t>(declared_child(tree, b))];
    const Force<double> W = as_force(reaction(tree, state, workspace, tree.inboard_joint({b})));
    force = std::max(force, length(real(W.l) - child.force));
    torque = std::max(torque, length(real(W.h) - child.torque));
    most = std::max(most, length(child.force));
    context = std::max(context, length(child.torque));
  }
  enter("accelerations of origins", linear, fast + whirl, bound);
  enter("angular accelerations", angular, fast + whirl, bound);
  enter("forces of joints", force, most + weight, bound);
  enter("torques of joints", torque, context + most + weight, bound);
  laws.push_back(
      {"Newton and Euler", equations_of_motion(system, tree, state, workspace), range.condition() > 1e6 ? 1e-9 : 1e-10});
  laws.push_back({"E^T Tr = tau - rotor dv/dt", work_of_reactions(tree, state, workspace), 1e-12});
  return laws;
}

}  // namespace momentree::oracle
