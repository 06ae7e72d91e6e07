#include <tests/oracle/laws.hpp>

#include <cmath>
#include <limits>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <tests/oracle/kinematics.hpp>

namespace momentree::oracle {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon() / 2;  // unit round-off

std::vector<Real> wide(const double* a, int n) { return {a, a + n}; }
double narrow(Real x) { return static_cast<double>(x); }
/// Error relative to a size; if the size is zero, the error must be zero.
double relative(Real error, Real size) { return error == 0 ? 0 : narrow(error / size); }
Real length(const V3<Real>& a) { return std::sqrt(dot(a, a)); }

/// p against EᵀPb + armature with the oracle's columns; the largest error over all DoFs, relative to the summands: |E||Pb| and,
/// since Pb is the sum over all outboard bodies, each of which moves with the velocities of all its ancestors, |M||v|. The second
/// measure is stricter: relative to |E||Pb| alone, the error is amplified by cancellation in Pb, and it can only be bounded by
/// the condition of the mass.
void measure_projection(const System& system, const std::vector<double>& q, const MassMatrix& mass, double condition,
                        const Tree& tree, const State& state, const Workspace<double>& workspace, std::vector<Measure>& laws) {
  double worst = 0, worst_left = 0;
  for (int b = 0; b < tree.bodies(); ++b) {
    const auto columns = joint_columns(system, q, b);
    if (columns.empty()) continue;
    const Force<double> Pb = articulated_momentum(tree, state, workspace, b);
    const KernelFrame& frame = tree.frame(b);  // frame of the kernels, in the user's frame
    const Frame<Real> at{
        {{frame.R.xx, frame.R.xy, frame.R.xz, frame.R.yx, frame.R.yy, frame.R.yz, frame.R.zx, frame.R.zy, frame.R.zz}},
        real(frame.r)};
    const V3<Real> l = at.rotation * real(Pb.l), h = at.rotation * real(Pb.h);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto& e = columns[i];
      const V3<Real> w{{e[3], e[4], e[5]}}, v = V3<Real>{{e[0], e[1], e[2]}} + cross(w, at.position);
      const int k = tree.first_p(b) + static_cast<int>(i);
      const Real rotor = static_cast<Real>(tree.tables().armature[k]) * workspace.v[static_cast<std::size_t>(k)];
      const Real p = state.p()[static_cast<std::size_t>(k)];
      const Real left = length(v) * length(l) + length(w) * length(h) + std::fabs(rotor) + std::fabs(p);
      Real summands = left;
      for (int c = 0; c < tree.nv(); ++c) summands += std::fabs(mass(k, c) * workspace.v[static_cast<std::size_t>(c)]);
      const Real error = std::fabs(dot(v, l) + dot(w, h) + rotor - p);
      if (!(error <= worst * summands)) worst = narrow(error / summands);
      if (!(error <= worst_left * left)) worst_left = narrow(error / left);
    }
  }
  laws.push_back({"E^T P + rotor = p", worst, 1e-14});
  laws.push_back({"E^T P + rotor = p, of |E||P|", worst_left, std::max(1e-14, 10 * epsilon * condition)});
}

/// Coordinate rates: v for plain coordinates, ½ Q (0, ω) for quaternions, R v for a free position.
Measure coordinate_rates(const System& system, const std::vector<double>& q, const Workspace<double>& workspace) {
  Real worst = 0;
  for (std::size_t k = 0; k < system.links.size(); ++k) {
    const Kind kind = system.links[k].joint.kind;
    const double* qk = q.data() + system.first_q[k];
    const double* rate = workspace.qdot.get() + system.first_q[k];
    const double* u = workspace.v.get() + system.first_v[k];
    std::vector<Real> expected;
    if (kind == Kind::ball || kind == Kind::free) {
      if (kind == Kind::free) {
        const V3<Real> r = matrix_of(qk[3], qk[4], qk[5], qk[6]) * V3<Real>{{u[0], u[1], u[2]}};
        expected.assign(r.begin(), r.end());
        qk += 3;
        u += 3;
      }
      const Real w = qk[0], x = qk[1], y = qk[2], z = qk[3];
      for (const Real c : {-x * u[0] - y * u[1] - z * u[2], w * u[0] + y * u[2] - z * u[1], w * u[1] + z * u[0] - x * u[2],
                           w * u[2] + x * u[1] - y * u[0]})
        expected.push_back(c / 2);
    } else {
      expected = wide(u, coordinates(kind));
    }
    const Real scale = norm(expected);
    if (scale > 0) worst = std::max(worst, distance(wide(rate, coordinates(kind)), expected) / scale);
  }
  return {"dq/dt", narrow(worst), 1e-14};
}

V3<Real> minus(const Vec3& a, const V3<Real>& b) { return real(a) - b; }

/// Poses and velocities of bodies, energies and momenta, at the engine's own velocities.
void measure_bodies(const System& system, const std::vector<double>& q, const Tree& tree, const State& state,
                    Workspace<double>& workspace, std::vector<Measure>& laws) {
  const std::vector<Real> v = wide(workspace.v.get(), tree.nv());
  const Evaluation e = evaluate(system, q, v, false);
  const Totals sum = totals(tree, state, workspace);
  Real place = 0, turn = 0, speed = 0, spin = 0, reach = 1, fast = 0, whirl = 0, all = 0, weight = 0;
  for (std::size_t k = 0; k < e.motions.size(); ++k) {
    const auto& m = e.motions[k];
    const Kinematics<double>& body = workspace.bodies[k];
    const Pose pose = user_pose(tree, body, static_cast<int>(k));
    const Vec3 w = body.R * body.velocity.w;
    const Vec3 velocity = body.R * body.velocity.v + momentree::cross(w, pose.position - body.r);
    place = std::max(place, length(minus(pose.position, m.frame.position)));
    speed = std::max(speed, length(minus(velocity, m.velocity)));
    spin = std::max(spin, length(minus(w, m.angular)));
    const M3<Real> R = matrix_of(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z);
    for (unsigned i = 0; i < 9; ++i) turn = std::max(turn, std::fabs(R[i] - m.frame.rotation[i]));
    const Real mass = system.links[k].mass;
    reach = std::max(reach, length(m.frame.position));
    fast = std::max(fast, length(m.velocity));
    whirl = std::max(whirl, length(m.angular));
    all += mass;
    weight += mass * (1 + length(m.com)) * length(system.gravity);
  }
  laws.push_back({"body positions", narrow(place), narrow(1e-13L * reach)});
  laws.push_back({"body attitudes", narrow(turn), 1e-13});
  laws.push_back({"body velocities", narrow(speed), narrow(1e-13L * (fast + whirl * reach))});
  laws.push_back({"body angular velocities", narrow(spin), narrow(1e-13L * whirl)});
  laws.push_back({"kinetic energy", narrow(std::fabs(sum.kinetic - e.kinetic)), narrow(1e-12L * e.kinetic)});
  laws.push_back(
      {"potential energy", narrow(std::fabs(sum.potential - e.potential)), narrow(1e-13L * (weight + std::fabs(e.potential)))});
  laws.push_back({"linear momentum", narrow(length(minus(sum.linear, e.linear))), narrow(1e-13L * all * (fast + whirl))});
  laws.push_back(
      {"angular momentum", narrow(length(minus(sum.angular, e.angular))), narrow(1e-13L * all * (fast + whirl) * reach)});
}

}  // namespace

Real norm(const std::vector<Real>& a) {
  Real sum = 0;
  for (const Real x : a) sum += x * x;
  return std::sqrt(sum);
}

Real distance(const std::vector<Real>& a, const std::vector<Real>& b) {
  std::vector<Real> d(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) d[i] = a[i] - b[i];
  return norm(d);
}

StateMeasures measure_state(const System& system, const Tree& tree, const State& state, Workspace<double>& workspace) {
  const std::vector<double> q(state.q().begin(), state.q().end());
  const int nv = tree.nv();
  forward_dynamics(tree, state, workspace);
  const std::vector<Real> p = wide(state.p().data(), nv), v = wide(workspace.v.get(), nv), rates = wide(workspace.pdot.get(), nv);

  const MassMatrix mass = mass_matrix(system, q);
  StateMeasures out;
  out.range = spectrum(mass);
  const double condition = out.range.condition();
  std::vector<Measure>& laws = out.laws;
  if (nv > 0) {
    const Real most = out.range.largest;
    laws.push_back({"M v = p", narrow(distance(mass.times(v), p)), narrow(1e-13L * (most * norm(v) + norm(p)))});
    const std::vector<Real> exact = solve(mass, p);
    laws.push_back({"v", relative(distance(v, exact), norm(exact)), 10 * epsilon * condition});
    const Evaluation e = evaluate(system, q, exact);
    laws.push_back({"dp/dt", relative(distance(rates, e.pdot), norm(e.pdot)), std::max(1e-9, 10 * epsilon * condition)});
    laws.push_back({"Lagrange = d'Alembert", relative(distance(e.pdot, e.pdot_alembert), norm(e.pdot)), 1e-13});
  }
  measure_projection(system, q, mass, condition, tree, state, workspace, laws);
  laws.push_back(coordinate_rates(system, q, workspace));
  measure_bodies(system, q, tree, state, workspace, laws);
  return out;
}

std::vector<Measure> measure_round_trip(const System& system, const std::vector<double>& given, const Tree& tree,
                                        const State& start, Workspace<double>& workspace) {
  const int nv = tree.nv();
  if (nv == 0) return {};
  const std::vector<double> q(start.q().begin(), start.q().end());
  const std::vector<Real> v = wide(given.data(), nv);
  const MassMatrix mass = mass_matrix(system, q);
  const Spectrum range = spectrum(mass);
  forward_dynamics(tree, start, workspace);
  return {{"p = M v", narrow(distance(wide(start.p().data(), nv), mass.times(v))),
           narrow(1e-14L * static_cast<Real>(range.largest) * norm(v))},
          {"v to p to v", relative(distance(wide(workspace.v.get(), nv), v), norm(v)), 10 * epsilon * range.condition()}};
}

}  // namespace momentree::oracle
