// Joint forces and spring energies, according to the documentation.
#include <tests/oracle/kinematics.hpp>

namespace momentree::oracle {
namespace {

Real value(const Values& values, int i) {
  if (values.empty()) return 0;
  return values.size() == 1 ? values[0] : values[i];
}

/// Rotation vector of rest⁻¹ q, of length at most π.
V3<Dual> rotation_from(const Real rest[4], const Dual q[4]) {
  const Dual w = rest[0] * q[0] + rest[1] * q[1] + rest[2] * q[2] + rest[3] * q[3];
  const Dual x = rest[0] * q[1] - rest[1] * q[0] - rest[2] * q[3] + rest[3] * q[2];
  const Dual y = rest[0] * q[2] + rest[1] * q[3] - rest[2] * q[0] - rest[3] * q[1];
  const Dual z = rest[0] * q[3] - rest[1] * q[2] + rest[2] * q[1] - rest[3] * q[0];
  const Dual s = sqrt(x * x + y * y + z * z);
  const Real sign = w.r < 0 ? -1 : 1;
  const Dual factor = s.r == 0 ? Dual(2 * sign / w.r) : (2 * sign) * atan2(s, sign * w) / s;
  return {{factor * x, factor * y, factor * z}};
}

/// Extension of each spring, with DoF `dof` displaced by ε; for a free joint's position along the parent-side axes.
std::vector<Dual> extensions(const JointSpec& joint, const double* q, int dof) {
  const Values& rest = joint.parameters.rest;
  const bool ball = joint.kind == Kind::ball, free = joint.kind == Kind::free;
  const auto at_rest = [&](int i) { return rest.empty() ? Real(0) : Real(rest[i]); };
  std::vector<Dual> x;
  if (!ball && !free)
    for (int i = 0; i < coordinates(joint.kind); ++i) x.push_back({q[i] - at_rest(i), dof == i ? Real(1) : Real(0)});
  const int plain = free ? 3 : 0;
  const double* Q = q + plain;
  if (free) {
    const M3<Real> R = matrix_of(Q[0], Q[1], Q[2], Q[3]);
    for (int i = 0; i < 3; ++i) x.push_back({q[i] - at_rest(i), dof >= 0 && dof < 3 ? R[static_cast<unsigned>(3 * i + dof)] : 0});
  }
  if (ball || free) {
    Real r[4] = {1, 0, 0, 0};
    for (int i = 0; i < 4 && !rest.empty(); ++i) r[i] = rest[plain + i];
    Real d[3] = {0, 0, 0};  // half a turn of ε about the child's axis: q (1, ½ ε e)
    if (dof >= plain) d[dof - plain] = 0.5L;
    const Dual moved[4] = {{Q[0], -Q[1] * d[0] - Q[2] * d[1] - Q[3] * d[2]},
                           {Q[1], Q[0] * d[0] + Q[2] * d[2] - Q[3] * d[1]},
                           {Q[2], Q[0] * d[1] + Q[3] * d[0] - Q[1] * d[2]},
                           {Q[3], Q[0] * d[2] + Q[1] * d[1] - Q[2] * d[0]}};
    for (const Dual& phi : rotation_from(r, moved)) x.push_back(phi);
  }
  return x;
}

/// Energy of the joint's springs: ½ Σ k x².
Dual spring_energy(const JointSpec& joint, const double* q, int dof) {
  Dual energy = 0;
  if (joint.parameters.stiffness.empty()) return energy;
  const std::vector<Dual> x = extensions(joint, q, dof);
  for (std::size_t i = 0; i < x.size(); ++i)
    energy = energy + (value(joint.parameters.stiffness, static_cast<int>(i)) / 2) * (x[i] * x[i]);
  return energy;
}

/// Penetration of a DoF into its soft stops, negative at the lower one; 0 if it is within them or has none.
Real beyond(const JointParameters& p, const double* q, int i) {
  if (p.limits.stiffness.empty()) return 0;
  if (!p.limits.upper.empty() && Real(q[i]) > value(p.limits.upper, i)) return Real(q[i]) - value(p.limits.upper, i);
  if (!p.limits.lower.empty() && Real(q[i]) < value(p.limits.lower, i)) return Real(q[i]) - value(p.limits.lower, i);
  return 0;
}

/// Friction, soft stops, efforts and position control.
Real driving_force(const JointParameters& p, const double* q, Real u, int i, Real t) {
  Real force = 0;
  if (const Real coulomb = value(p.friction.coulomb, i); coulomb != 0) {
    const Real e = std::exp(-2 * std::fabs(u) / value(p.friction.speed, i));  // tanh
    force -= (u < 0 ? -1 : 1) * coulomb * (1 - e) / (1 + e);
  }
  if (const Real x = beyond(p, q, i); x != 0) {
    const Real sign = x < 0 ? -1 : 1, push = value(p.limits.stiffness, i) * x * sign + value(p.limits.damping, i) * u * sign;
    if (push > 0) force -= sign * push;
  }
  if (!p.drive) return force;
  const auto pick = [i](const std::vector<Signal>& all) { return all[all.size() == 1 ? 0 : static_cast<std::size_t>(i)]; };
  if (!p.drive->effort.empty()) force += signal_at(pick(p.drive->effort), t).r;
  const JointDrive::Pd& pd = p.drive->pd;
  if (pd.kp.empty() && pd.kd.empty()) return force;
  const Curve target = pd.target.empty() ? Curve(0) : signal_at(pick(pd.target), t);
  const Real speed = pd.target_speed.empty() ? target.t : signal_at(pick(pd.target_speed), t).r;
  Real control = value(pd.kp, i) * (target.r - q[i]) + value(pd.kd, i) * (speed - u);
  if (!pd.max_effort.empty() && std::fabs(control) > value(pd.max_effort, i))
    control = control > 0 ? value(pd.max_effort, i) : -value(pd.max_effort, i);
  return force + control;
}

}  // namespace

Curve signal_at(const Signal& signal, Real t) {
  const auto knots = signal.knots();
  if (knots.empty()) {
    const Real w = 8 * std::atan(Real(1)) * signal.frequency(), a = signal.amplitude();
    const Real angle = w * t + signal.phase();
    return {signal.offset() + a * std::sin(angle), a * w * std::cos(angle), -a * w * w * std::sin(angle)};
  }
  if (t < knots.front().time) return {knots.front().value};
  for (std::size_t k = 1; k < knots.size(); ++k) {
    if (t >= knots[k].time) continue;
    const Real slope = (Real(knots[k].value) - knots[k - 1].value) / (Real(knots[k].time) - knots[k - 1].time);
    return {knots[k - 1].value + slope * (t - knots[k - 1].time), slope};
  }
  return {knots.back().value};
}

std::vector<Real> joint_forces(const System& system, const std::vector<double>& q, const std::vector<Real>& v) {
  std::vector<Real> force(static_cast<std::size_t>(system.nv()), 0);
  for (std::size_t k = 0; k < system.links.size(); ++k) {
    const JointSpec& joint = system.links[k].joint;
    const JointParameters& p = joint.parameters;
    const double* qk = q.data() + system.first_q[k];
    const Real* vk = v.data() + system.first_v[k];
    Real* fk = force.data() + system.first_v[k];
    for (int i = 0; i < dofs(joint.kind); ++i)
      fk[i] = value(p.effort, i) - value(p.damping, i) * vk[i] - spring_energy(joint, qk, i).e +
              driving_force(p, qk, vk[i], i, system.time);
  }
  return force;
}

Real potential(const System& system, const std::vector<double>& q) {
  Real energy = 0;
  const std::vector<Mount> mount = mounts(system);
  std::vector<Frame<Dual>> frame(system.links.size());
  for (std::size_t k = 0; k < system.links.size(); ++k) {
    const Link& link = system.links[k];
    const double* qk = q.data() + system.first_q[k];
    const Frame<Dual> parent = link.parent < 0 ? Frame<Dual>{} : frame[static_cast<std::size_t>(link.parent)];
    frame[k] = body_frame(link, mount[k], parent, qk, {});
    const V3<Dual> com = frame[k].position + frame[k].rotation * mount[k].com;
    energy -= link.mass * (system.gravity[0] * com[0].r + system.gravity[1] * com[1].r + system.gravity[2] * com[2].r);
    energy += spring_energy(link.joint, qk, -1).r;
    const JointParameters& p = link.joint.parameters;
    for (int i = 0; i < dofs(link.joint.kind); ++i) {
      const Real x = beyond(p, qk, i);
      energy += value(p.limits.stiffness, i) * x * x / 2;
    }
  }
  return energy;
}

}  // namespace momentree::oracle
