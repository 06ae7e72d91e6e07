#include <tests/oracle/oracle.hpp>

#include <tests/oracle/kinematics.hpp>

namespace momentree::oracle {
namespace {

/// Real parts, ε parts, … of a vector or matrix of series.
template <class Out, class In, class Part>
Out part(const In& in, Part which) {
  Out out;
  for (unsigned i = 0; i < out.size(); ++i) out[i] = in[i].*which;
  return out;
}

/// Frames of all bodies, without a perturbation ε.
template <class T>
std::vector<Frame<T>> all_frames(const System& system, const std::vector<Mount>& mount, const std::vector<double>& q,
                                 const Real* v) {
  std::vector<Frame<T>> frame(system.links.size());
  for (std::size_t k = 0; k < frame.size(); ++k) {
    const Link& link = system.links[k];
    const Frame<T> parent = link.parent < 0 ? Frame<T>{} : frame[static_cast<std::size_t>(link.parent)];
    const Perturbation by{v ? v + system.first_v[k] : nullptr, -1, true};
    frame[k] = body_frame(link, mount[k], parent, q.data() + system.first_q[k], by);
  }
  return frame;
}

/// Calls visit(k, frame) for `link` and all its descendants, with DoF `dof` of its joint displaced by ε.
template <class T, class Visit>
void moved(const System& system, const std::vector<Mount>& mount, const std::vector<Frame<T>>& still,
           const std::vector<double>& q, const Real* v, std::size_t link, int dof, bool epsilon_first,
           std::vector<Frame<T>>& frame, Visit visit) {
  std::vector<char> inside(system.links.size(), 0);
  for (std::size_t k = link; k < frame.size(); ++k) {
    const int parent = system.links[k].parent;
    if (k != link && (parent < 0 || !inside[static_cast<std::size_t>(parent)])) continue;
    inside[k] = 1;
    const Perturbation by{v ? v + system.first_v[k] : nullptr, k == link ? dof : -1, epsilon_first};
    const Frame<T> origin = parent < 0  ? Frame<T>{}
                            : k == link ? still[static_cast<std::size_t>(parent)]
                                        : frame[static_cast<std::size_t>(parent)];
    frame[k] = body_frame(system.links[k], mount[k], origin, q.data() + system.first_q[k], by);
    visit(k, frame[k]);
  }
}

/// World axes.
M3<Real> turned(const M3<Real>& rotation, const M3<Real>& inertia) { return rotation * inertia * transposed(rotation); }

using Column = std::array<Real, 6>;  // of a Jacobian: motion of the centre of mass, rotation; world axes

}  // namespace

std::vector<Real> MassMatrix::times(const std::vector<Real>& v) const {
  std::vector<Real> out(static_cast<std::size_t>(n_), 0);
  for (int i = 0; i < n_; ++i)
    for (int j = 0; j < n_; ++j) out[static_cast<std::size_t>(i)] += (*this)(i, j) * v[static_cast<std::size_t>(j)];
  return out;
}

MassMatrix mass_matrix(const System& system, const std::vector<double>& q) {
  const std::vector<Mount> mount = mounts(system);
  const std::size_t n = system.links.size();
  const std::vector<Frame<Dual>> still = all_frames<Dual>(system, mount, q, nullptr);
  std::vector<std::vector<std::pair<int, Column>>> jacobian(n);  // per body: the DoFs that move it
  std::vector<Frame<Dual>> frame(n);
  for (std::size_t j = 0; j < n; ++j)
    for (int i = 0; i < dofs(system.links[j].joint.kind); ++i)
      moved(system, mount, still, q, nullptr, j, i, true, frame, [&](std::size_t k, const Frame<Dual>& f) {
        const V3<Dual> com = f.position + f.rotation * mount[k].com;
        const M3<Real> r = part<M3<Real>>(f.rotation, &Dual::r), dr = part<M3<Real>>(f.rotation, &Dual::e);
        const V3<Real> turning = axial(dr * transposed(r));
        jacobian[k].push_back({system.first_v[j] + i, {com[0].e, com[1].e, com[2].e, turning[0], turning[1], turning[2]}});
      });

  MassMatrix mass(system.nv());
  for (std::size_t k = 0; k < n; ++k) {
    const M3<Real> inertia = turned(part<M3<Real>>(still[k].rotation, &Dual::r), mount[k].inertia);
    const Real m = system.links[k].mass;
    for (std::size_t a = 0; a < jacobian[k].size(); ++a) {
      const auto& [ia, ja] = jacobian[k][a];
      const V3<Real> h = inertia * V3<Real>{{ja[3], ja[4], ja[5]}};
      const Column w{m * ja[0], m * ja[1], m * ja[2], h[0], h[1], h[2]};
      for (std::size_t b = 0; b <= a; ++b) {
        const auto& [ib, jb] = jacobian[k][b];
        mass(ia, ib) += w[0] * jb[0] + w[1] * jb[1] + w[2] * jb[2] + w[3] * jb[3] + w[4] * jb[4] + w[5] * jb[5];
      }
    }
    const Values& armature = system.links[k].joint.parameters.armature;
    for (int i = 0; i < dofs(system.links[k].joint.kind) && !armature.empty(); ++i)
      mass(system.first_v[k] + i, system.first_v[k] + i) += armature.size() == 1 ? armature[0] : armature[i];
  }
  for (int i = 0; i < mass.size(); ++i)
    for (int j = 0; j < i; ++j) mass(j, i) = mass(i, j);
  return mass;
}

std::vector<Real> solve(const MassMatrix& mass, const std::vector<Real>& p) {
  // M = Lᵀ D L, starting with the last DoF: since parents are numbered before their children, no zero of M fills in.
  MassMatrix f = mass;
  const int n = mass.size();
  std::vector<int> row;
  for (int k = n - 1; k >= 0; --k) {
    row.clear();
    for (int i = 0; i < k; ++i)
      if (f(k, i) != 0) row.push_back(i);
    for (const int i : row) {
      const Real factor = f(k, i) / f(k, k);
      for (const int j : row) {
        if (j > i) break;
        f(i, j) -= factor * f(k, j);
      }
    }
    for (const int i : row) f(k, i) /= f(k, k);
  }
  std::vector<Real> x = p;
  for (int k = n - 1; k >= 0; --k)
    for (int i = 0; i < k; ++i) x[static_cast<std::size_t>(i)] -= f(k, i) * x[static_cast<std::size_t>(k)];
  for (int k = 0; k < n; ++k) {
    x[static_cast<std::size_t>(k)] /= f(k, k);
    for (int i = 0; i < k; ++i) x[static_cast<std::size_t>(k)] -= f(k, i) * x[static_cast<std::size_t>(i)];
  }
  return x;
}

Evaluation evaluate(const System& system, const std::vector<double>& q, const std::vector<Real>& v, bool with_rates) {
  const std::vector<Mount> mount = mounts(system);
  const std::size_t n = system.links.size();
  const std::vector<Frame<Jet>> still = all_frames<Jet>(system, mount, q, v.data());
  Evaluation out;
  out.motions.resize(n);
  std::vector<V3<Real>> linear(n), angular(n);  // momenta of each body, angular about its centre of mass
  for (std::size_t k = 0; k < n; ++k) {
    const V3<Jet> com = still[k].position + still[k].rotation * mount[k].com;
    const M3<Real> r = part<M3<Real>>(still[k].rotation, &Jet::r), dr = part<M3<Real>>(still[k].rotation, &Jet::t);
    Evaluation::Motion& m = out.motions[k];
    m.frame = {r, part<V3<Real>>(still[k].position, &Jet::r)};
    m.velocity = part<V3<Real>>(still[k].position, &Jet::t);
    m.com = part<V3<Real>>(com, &Jet::r);
    m.com_velocity = part<V3<Real>>(com, &Jet::t);
    m.angular = axial(dr * transposed(r));
    const Real mass = system.links[k].mass;
    linear[k] = scaled(mass, m.com_velocity);
    angular[k] = turned(r, mount[k].inertia) * m.angular;
    out.kinetic += (dot(linear[k], m.com_velocity) + dot(angular[k], m.angular)) / 2;
    out.linear = out.linear + linear[k];
    out.angular = out.angular + cross(m.com, linear[k]) + angular[k];
    const Values& armature = system.links[k].joint.parameters.armature;
    for (int i = 0; i < dofs(system.links[k].joint.kind) && !armature.empty(); ++i) {
      const Real u = v[static_cast<std::size_t>(system.first_v[k] + i)];
      out.kinetic += (armature.size() == 1 ? armature[0] : armature[i]) * u * u / 2;
    }
  }
  out.potential = potential(system, q);
  if (!with_rates) return out;

  out.pdot = out.pdot_alembert = joint_forces(system, q, v);
  std::vector<Real> momentum(out.pdot.size(), 0);  // without armature
  std::vector<Frame<Jet>> frame(n);
  for (std::size_t j = 0; j < n; ++j) {
    const bool group = system.links[j].joint.kind == Kind::ball || system.links[j].joint.kind == Kind::free;
    for (int i = 0; i < dofs(system.links[j].joint.kind); ++i) {
      const std::size_t a = static_cast<std::size_t>(system.first_v[j] + i);
      // ∂L/∂(DoF) at constant velocities: Σ m ċ·δċ + (Iω)·δω + m g·δc, ω in body axes.
      const auto lagrange = [&](std::size_t k, const Frame<Jet>& f) {
        const V3<Jet> com = f.position + f.rotation * mount[k].com;
        const M3<Real> r = part<M3<Real>>(f.rotation, &Jet::r), re = part<M3<Real>>(f.rotation, &Jet::e),
                       rt = part<M3<Real>>(f.rotation, &Jet::t), ret = part<M3<Real>>(f.rotation, &Jet::et);
        const M3<Real> a1 = transposed(re) * rt, a2 = transposed(r) * ret;
        M3<Real> change;
        for (unsigned c = 0; c < 9; ++c) change[c] = a1[c] + a2[c];
        const V3<Real> dc = part<V3<Real>>(com, &Jet::e);
        const V3<Real> body_momentum = transposed(r) * angular[k];
        momentum[a] += dot(linear[k], dc) + dot(angular[k], axial(re * transposed(r)));
        out.pdot[a] += dot(linear[k], part<V3<Real>>(com, &Jet::et)) + dot(body_momentum, axial(change)) +
                       system.links[k].mass * dot(system.gravity, dc);
      };
      // d'Alembert: p = Σ m ċ·∂ċ + h·∂ω and m c̈, ḣ are the applied forces, so ṗ = Σ m ċ·d(∂ċ) + h·d(∂ω) + m g·∂c + joint force.
      const auto alembert = [&](std::size_t k, const Frame<Jet>& f) {
        const V3<Jet> com = f.position + f.rotation * mount[k].com;
        const M3<Real> r = part<M3<Real>>(f.rotation, &Jet::r), re = part<M3<Real>>(f.rotation, &Jet::e),
                       rt = part<M3<Real>>(f.rotation, &Jet::t), ret = part<M3<Real>>(f.rotation, &Jet::et);
        const M3<Real> a1 = ret * transposed(r), a2 = re * transposed(rt);
        M3<Real> change;
        for (unsigned c = 0; c < 9; ++c) change[c] = a1[c] + a2[c];
        out.pdot_alembert[a] += dot(linear[k], part<V3<Real>>(com, &Jet::et)) + dot(angular[k], axial(change)) +
                                system.links[k].mass * dot(system.gravity, part<V3<Real>>(com, &Jet::e));
      };
      if (group) {
        moved(system, mount, still, q, v.data(), j, i, true, frame, lagrange);
        moved(system, mount, still, q, v.data(), j, i, false, frame, alembert);
      } else {
        moved(system, mount, still, q, v.data(), j, i, true, frame, [&](std::size_t k, const Frame<Jet>& f) {
          lagrange(k, f);
          alembert(k, f);
        });
      }
    }
  }
  // Hamel's terms: the quasi-velocities of ball and free joints do not commute.
  for (std::size_t j = 0; j < n; ++j) {
    const Kind kind = system.links[j].joint.kind;
    if (kind != Kind::ball && kind != Kind::free) continue;
    const std::size_t a = static_cast<std::size_t>(system.first_v[j]), h = kind == Kind::free ? a + 3 : a;
    const V3<Real> w{{v[h], v[h + 1], v[h + 2]}}, ph{{momentum[h], momentum[h + 1], momentum[h + 2]}};
    V3<Real> turning = cross(w, ph);
    if (kind == Kind::free) {
      const V3<Real> u{{v[a], v[a + 1], v[a + 2]}}, pl{{momentum[a], momentum[a + 1], momentum[a + 2]}};
      const V3<Real> sliding = cross(w, pl);
      turning = turning + cross(u, pl);
      for (unsigned i = 0; i < 3; ++i) out.pdot[a + i] -= sliding[i];
    }
    for (unsigned i = 0; i < 3; ++i) out.pdot[h + i] -= turning[i];
  }
  return out;
}

std::vector<std::array<Real, 6>> joint_columns(const System& system, const std::vector<double>& q, int link) {
  const std::size_t k = static_cast<std::size_t>(link);
  const std::vector<Mount> mount = mounts(system);
  std::vector<std::array<Real, 6>> columns;
  for (int i = 0; i < dofs(system.links[k].joint.kind); ++i) {
    const Frame<Dual> f = body_frame(system.links[k], mount[k], Frame<Dual>{}, q.data() + system.first_q[k], {nullptr, i, true});
    const M3<Real> back = transposed(part<M3<Real>>(f.rotation, &Dual::r));
    const V3<Real> linear = back * part<V3<Real>>(f.position, &Dual::e);
    const V3<Real> angular = axial(back * part<M3<Real>>(f.rotation, &Dual::e));
    columns.push_back({linear[0], linear[1], linear[2], angular[0], angular[1], angular[2]});
  }
  return columns;
}

}  // namespace momentree::oracle
