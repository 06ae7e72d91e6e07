// The oracle's input from a model: numbers and topology.
#include <algorithm>

#include <tests/oracle/kinematics.hpp>

namespace momentree::oracle {

int coordinates(Kind kind) { return info(kind).nq; }
int dofs(Kind kind) { return info(kind).nv; }

void number(System& system) {
  int q = 0, v = 0;
  for (const Link& link : system.links) {
    system.first_q.push_back(q);
    system.first_v.push_back(v);
    q += coordinates(link.joint.kind);
    v += dofs(link.joint.kind);
  }
  system.first_q.push_back(q);
  system.first_v.push_back(v);
}

System system_of(const Model& model) {
  System system;
  system.gravity = real(model.gravity());
  for (const BodySpec& body : model.bodies())
    system.links.push_back({body.parent.index, body.joint, body.at, body.child_at, body.mass, body.com, body.inertia});
  number(system);
  return system;
}

System broken(System system, int body) {
  Link& link = system.links[static_cast<std::size_t>(body)];
  link.parent = -1;
  link.at = link.child_at = {};
  link.joint = {};
  link.joint.kind = Kind::free;
  system.first_q.clear();
  system.first_v.clear();
  number(system);
  return system;
}

std::vector<double> start_q(const Model& model) {
  std::vector<double> q;
  for (const BodySpec& body : model.bodies()) {
    const Kind kind = body.joint.kind;
    std::vector<double> own(static_cast<std::size_t>(coordinates(kind)), 0.0);
    if (kind == Kind::ball || kind == Kind::free) own[kind == Kind::free ? 3 : 0] = 1;  // the quaternion's real part
    std::copy(body.q.begin(), body.q.end(), own.begin());
    q.insert(q.end(), own.begin(), own.end());
  }
  return q;
}

std::vector<double> start_v(const Model& model) {
  std::vector<double> v;
  for (const BodySpec& body : model.bodies()) {
    std::vector<double> own(static_cast<std::size_t>(dofs(body.joint.kind)), 0.0);
    std::copy(body.v.begin(), body.v.end(), own.begin());
    v.insert(v.end(), own.begin(), own.end());
  }
  return v;
}

std::vector<Mount> mounts(const System& system) {
  std::vector<Mount> all;
  for (const Link& link : system.links) {
    const Sym3& j = link.inertia;
    all.push_back({frame_of(link.at),
                   inverse_of(frame_of(link.child_at)),
                   real(link.com),
                   {{j.xx, j.xy, j.xz, j.xy, j.yy, j.yz, j.xz, j.yz, j.zz}}});
  }
  return all;
}

namespace {
/// q exp(θ/2), θ in child axes.
void turn_quaternion(double* q, const V3<Real>& theta) {
  const Real angle = std::sqrt(dot(theta, theta)), c = std::cos(angle / 2);
  const Real s = angle == 0 ? Real(0.5) : std::sin(angle / 2) / angle;
  const Real w = q[0], x = q[1], y = q[2], z = q[3], a = s * theta[0], b = s * theta[1], d = s * theta[2];
  q[0] = static_cast<double>(w * c - x * a - y * b - z * d);
  q[1] = static_cast<double>(w * a + x * c + y * d - z * b);
  q[2] = static_cast<double>(w * b + y * c + z * a - x * d);
  q[3] = static_cast<double>(w * d + z * c + x * b - y * a);
}
}  // namespace

std::vector<double> displaced(const System& system, const std::vector<double>& q, const std::vector<Real>& v, Real h) {
  std::vector<double> out = q;
  for (std::size_t k = 0; k < system.links.size(); ++k) {
    double* qk = out.data() + system.first_q[k];
    const Real* vk = v.data() + system.first_v[k];
    const Kind kind = system.links[k].joint.kind;
    if (kind == Kind::ball) turn_quaternion(qk, {{h * vk[0], h * vk[1], h * vk[2]}});
    if (kind == Kind::free) {  // the mean of the attitudes at both ends transforms the origin's velocity
      const M3<Real> before = matrix_of(qk[3], qk[4], qk[5], qk[6]);
      turn_quaternion(qk + 3, {{h * vk[3], h * vk[4], h * vk[5]}});
      const M3<Real> after = matrix_of(qk[3], qk[4], qk[5], qk[6]);
      const V3<Real> s{{h * vk[0], h * vk[1], h * vk[2]}}, step = before * s + after * s;
      for (unsigned i = 0; i < 3; ++i) qk[i] += static_cast<double>(step[i] / 2);
    }
    if (kind == Kind::ball || kind == Kind::free) continue;
    for (int i = 0; i < coordinates(kind); ++i) qk[i] += static_cast<double>(h * vk[i]);
  }
  return out;
}

}  // namespace momentree::oracle
