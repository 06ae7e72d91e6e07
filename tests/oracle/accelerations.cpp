// Accelerations from second derivatives of poses, wrenches from the Newton–Euler equations of each body.
#include <cmath>

#include <tests/oracle/kinematics.hpp>

namespace momentree::oracle {
namespace {

/// Bodies that move with velocities v and accelerations `a`, and the joint wrenches that this requires.
std::vector<Accelerations::Body> moving(const System& system, const std::vector<double>& q, const Real* v, const Real* a) {
  const std::vector<Mount> mount = mounts(system);
  const std::size_t n = system.links.size();
  std::vector<Frame<Curve>> frame(n);
  std::vector<Accelerations::Body> out(n);
  const auto value = [](const auto& series, auto part) {
    std::conditional_t<sizeof(series) == sizeof(V3<Curve>), V3<Real>, M3<Real>> x;
    for (unsigned i = 0; i < x.size(); ++i) x[i] = series[i].*part;
    return x;
  };
  for (std::size_t k = 0; k < n; ++k) {
    const Link& link = system.links[k];
    const Frame<Curve> parent = link.parent < 0 ? Frame<Curve>{} : frame[static_cast<std::size_t>(link.parent)];
    const int at = system.first_v[k];
    frame[k] = body_frame(link, mount[k], parent, q.data() + system.first_q[k], {v + at, -1, true, a + at});
    // Ṙ Rᵀ = ω̃, R̈ Rᵀ = α̃ + ω̃ ω̃, whose axial part is α.
    const M3<Real> R = value(frame[k].rotation, &Curve::r), back = transposed(R);
    const V3<Real> w = axial(value(frame[k].rotation, &Curve::t) * back);
    const V3<Real> alpha = axial(value(frame[k].rotation, &Curve::tt) * back);
    const V3<Real> com = value(frame[k].position + frame[k].rotation * mount[k].com, &Curve::tt) - system.gravity;
    const M3<Real> inertia = R * mount[k].inertia * back;
    out[k].linear = value(frame[k].position, &Curve::tt);
    out[k].angular = alpha;
    out[k].force = scaled(static_cast<Real>(link.mass), com);
    out[k].torque = inertia * alpha + cross(w, inertia * w) + cross(R * mount[k].com, out[k].force);
  }
  for (std::size_t k = n; k-- > 0;) {  // parents come before their children
    const M3<Real> back = transposed(value(frame[k].rotation, &Curve::r));
    if (const int parent = system.links[k].parent; parent >= 0) {
      Accelerations::Body& outer = out[static_cast<std::size_t>(parent)];
      const V3<Real> arm = value(frame[k].position - frame[static_cast<std::size_t>(parent)].position, &Curve::r);
      outer.force = outer.force + out[k].force;
      outer.torque = outer.torque + out[k].torque + cross(arm, out[k].force);
    }
    out[k].force = back * out[k].force;
    out[k].torque = back * out[k].torque;
  }
  return out;
}

}  // namespace

Accelerations accelerate(const System& system, const std::vector<double>& q, const std::vector<Real>& v, const MassMatrix& mass,
                         const std::vector<char>& locked, const std::vector<Real>& given) {
  // M v̇ = τ − the forces required by the motion without v̇.
  std::vector<Real> force = joint_forces(system, q, v);
  const std::vector<Real> none(v.size(), 0);
  const std::vector<Accelerations::Body> still = moving(system, q, v.data(), none.data());
  std::vector<Real> size;
  for (const Real f : force) size.push_back(std::fabs(f));
  const auto both = [](const V3<Real>& x, const V3<Real>& y) { return std::sqrt(dot(x, x) * dot(y, y)); };
  for (std::size_t k = 0; k < system.links.size(); ++k) {
    auto i = static_cast<std::size_t>(system.first_v[k]);
    for (const auto& e : joint_columns(system, q, static_cast<int>(k))) {
      const V3<Real> linear{{e[0], e[1], e[2]}}, angular{{e[3], e[4], e[5]}};
      force[i] -= dot(linear, still[k].force) + dot(angular, still[k].torque);
      size[i] += both(linear, still[k].force) + both(angular, still[k].torque);
      ++i;
    }
  }
  MassMatrix free = mass;
  for (int i = 0; i < mass.size() && !locked.empty(); ++i) {
    if (!locked[static_cast<std::size_t>(i)]) continue;
    const Real a = given.empty() ? 0 : given[static_cast<std::size_t>(i)];
    for (int j = 0; j < mass.size(); ++j) {
      if (!locked[static_cast<std::size_t>(j)]) force[static_cast<std::size_t>(j)] -= mass(i, j) * a;
      free(i, j) = free(j, i) = i == j ? 1 : 0;
    }
    force[static_cast<std::size_t>(i)] = a;
    size[static_cast<std::size_t>(i)] = std::fabs(a);
  }
  Accelerations out;
  for (const Real x : solve(free, size)) out.summands += x * x;
  out.summands = std::sqrt(out.summands);
  out.v = solve(free, force);
  out.bodies = moving(system, q, v.data(), out.v.data());
  return out;
}

}  // namespace momentree::oracle
