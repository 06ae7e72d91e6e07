// Forces of joints and energies of springs, by the contract.
#include <tests/oracle/kinematics.hpp>

namespace momentree::oracle {
namespace {

Real value(const Values& values, int i) {
  if (values.empty()) return 0;
  return values.size() == 1 ? values[0] : values[i];
}

/// Rotation vector of rest⁻¹ q, of length at most π.
V3<Real> rotation_from(const Real rest[4], const double* q) {
  const Real w = rest[0] * q[0] + rest[1] * q[1] + rest[2] * q[2] + rest[3] * q[3];
  const Real x = rest[0] * q[1] - rest[1] * q[0] - rest[2] * q[3] + rest[3] * q[2];
  const Real y = rest[0] * q[2] + rest[1] * q[3] - rest[2] * q[0] - rest[3] * q[1];
  const Real z = rest[0] * q[3] - rest[1] * q[2] + rest[2] * q[1] - rest[3] * q[0];
  const Real s = std::sqrt(x * x + y * y + z * z);
  if (s == 0) return {};
  const Real half = std::atan2(s, std::fabs(w));
  const Real factor = (w < 0 ? -2 : 2) * half / s;
  return {{factor * x, factor * y, factor * z}};
}

/// Extension of each spring, and where it pulls (for a free joint's position in parent-side axes).
std::vector<Real> extensions(const JointSpec& joint, const double* q) {
  const Values& rest = joint.parameters.rest;
  const bool ball = joint.kind == Kind::ball, free = joint.kind == Kind::free;
  std::vector<Real> x;
  const int plain = ball ? 0 : free ? 3 : coordinates(joint.kind);
  for (int i = 0; i < plain; ++i) x.push_back(q[i] - (rest.empty() ? 0 : static_cast<Real>(rest[i])));
  if (ball || free) {
    Real r[4] = {1, 0, 0, 0};
    for (int i = 0; i < 4 && !rest.empty(); ++i) r[i] = rest[plain + i];
    for (const Real phi : rotation_from(r, q + plain)) x.push_back(phi);
  }
  return x;
}

}  // namespace

std::vector<Real> joint_forces(const System& system, const std::vector<double>& q, const std::vector<Real>& v) {
  std::vector<Real> force(static_cast<std::size_t>(system.nv()), 0);
  for (std::size_t k = 0; k < system.links.size(); ++k) {
    const JointSpec& joint = system.links[k].joint;
    const JointParameters& p = joint.parameters;
    const double* qk = q.data() + system.first_q[k];
    const Real* vk = v.data() + system.first_v[k];
    Real* fk = force.data() + system.first_v[k];
    const std::vector<Real> x = extensions(joint, qk);
    std::vector<Real> spring(x.size(), 0);
    for (std::size_t i = 0; i < x.size(); ++i) spring[i] = -value(p.stiffness, static_cast<int>(i)) * x[i];
    if (joint.kind == Kind::free) {  // δr = R δs with s in child-side axes
      const V3<Real> pull = transposed(matrix_of(qk[3], qk[4], qk[5], qk[6])) * V3<Real>{{spring[0], spring[1], spring[2]}};
      for (unsigned i = 0; i < 3; ++i) spring[i] = pull[i];
    }
    for (int i = 0; i < freedoms(joint.kind); ++i)
      fk[i] = value(p.effort, i) - value(p.damping, i) * vk[i] + spring[static_cast<std::size_t>(i)];
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
    const std::vector<Real> x = extensions(link.joint, qk);
    for (std::size_t i = 0; i < x.size(); ++i) energy += value(link.joint.parameters.stiffness, static_cast<int>(i)) * x[i] * x[i] / 2;
  }
  return energy;
}

}  // namespace momentree::oracle
