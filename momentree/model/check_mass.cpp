// Checks whether mass and inertia are physically possible, per body and per group of rigidly joined bodies.
#include <algorithm>
#include <array>
#include <cmath>

#include <momentree/math/point_inertia.hpp>
#include <momentree/model/model.hpp>

namespace momentree {

namespace {

constexpr double round_off = 1e-9, cad_rounding = 2e-2;  // relative to the largest principal moment

// Principal moments in ascending order, by Jacobi rotations: accurate for any scale and for repeated values.
std::array<double, 3> principal_moments(const Sym3& inertia) {
  double a[3][3] = {
      {inertia.xx, inertia.xy, inertia.xz}, {inertia.xy, inertia.yy, inertia.yz}, {inertia.xz, inertia.yz, inertia.zz}};
  for (int sweep = 0; sweep < 30; ++sweep)
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = std::copysign(1.0, theta) / (std::fabs(theta) + std::hypot(theta, 1.0));
        const double c = 1 / std::hypot(t, 1.0), s = t * c;
        for (auto& row : a) {
          const double ip = row[p], iq = row[q];
          row[p] = c * ip - s * iq, row[q] = s * ip + c * iq;
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk - s * qk, a[q][k] = s * pk + c * qk;
        }
        a[p][q] = a[q][p] = 0;
      }
  std::array<double, 3> moments{a[0][0], a[1][1], a[2][2]};
  std::sort(moments.begin(), moments.end());
  return moments;
}

double largest(const Sym3& i) {
  return std::max({std::fabs(i.xx), std::fabs(i.yy), std::fabs(i.zz), std::fabs(i.xy), std::fabs(i.xz), std::fabs(i.yz)});
}

// Rigidly joined bodies, in the frame of the first of them.
struct Group {
  double mass = 0;
  Vec3 moment{};
  Sym3 inertia{};  // about the origin of that frame
  int bodies = 0;
};

// Other faults are reported by check_body().
bool usable(const BodySpec& b) {
  return std::isfinite(b.mass) && b.mass >= 0 && std::isfinite(largest(b.inertia)) && std::isfinite(dot(b.com, b.com)) &&
         std::isfinite(norm(b.at.position));
}

}  // namespace

MassProblem check_mass(double mass, const Sym3& inertia) {
  if (!std::isfinite(mass)) return {"mass: must be finite", ""};
  if (mass < 0) return {"mass: must not be negative", ""};
  const double scale = largest(inertia);
  for (double x : {inertia.xx, inertia.yy, inertia.zz, inertia.xy, inertia.xz, inertia.yz})
    if (!std::isfinite(x)) return {"inertia: must be finite", ""};
  if (scale == 0) return {};
  if (mass == 0) return {"inertia: a body without mass has none", "give a mass, or an inertia of 0"};

  const double f = 1 / scale;
  const auto m =
      principal_moments({f * inertia.xx, f * inertia.yy, f * inertia.zz, f * inertia.xy, f * inertia.xz, f * inertia.yz});
  if (m[2] <= 0 || m[0] < -cad_rounding * m[2])
    return {"inertia: no body has a negative principal moment", "the order is xx, yy, zz, xy, xz, yz, about the centre of mass"};
  const double excess = (m[2] - m[0] - m[1]) / m[2];
  if (excess > cad_rounding)
    return {"inertia: the largest principal moment is more than the sum of the others, which no body has",
            "it is meant about the centre of mass, and products of inertia as elements of the matrix (xy = −Σ m x y)"};
  if (m[0] < -round_off * m[2])
    return {"inertia: a principal moment is slightly negative", "rounded values? give more digits", true};
  if (excess > round_off)
    return {"inertia: the largest principal moment is slightly more than the sum of the others",
            "rounded values? give more digits", true};
  return {};
}

std::vector<GroupMassProblem> check_masses(std::span<const BodySpec> bodies) {
  const int n = static_cast<int>(bodies.size());
  std::vector<GroupMassProblem> problems;
  for (int b = 0; b < n; ++b) {
    if (!usable(bodies[b])) continue;
    MassProblem problem = check_mass(bodies[b].mass, bodies[b].inertia);
    if (!problem.what.empty()) problems.push_back({{b}, std::move(problem)});
  }
  if (problems.empty()) return problems;  // a sum of possible inertias is possible

  std::vector<int> first(n);      // first body of the body's group
  std::vector<Pose> in_group(n);  // placement in the frame of that body
  std::vector<Group> groups(n);
  for (int b = 0; b < n; ++b) {
    const BodySpec& body = bodies[b];
    const int parent = body.parent.index;
    const bool joined = body.joint.kind == Kind::weld && parent >= 0 && parent < b;
    first[b] = joined ? first[parent] : b;
    if (joined) in_group[b] = in_group[parent] * body.at * inverse(body.child_at);
    if (!usable(body)) continue;
    Group& group = groups[first[b]];
    const Vec3 com = in_group[b] * body.com;
    group.mass += body.mass;
    group.moment += body.mass * com;
    group.inertia = group.inertia + rotate(rotation_matrix(in_group[b].rotation), body.inertia) + point_inertia(body.mass, com);
    ++group.bodies;
  }
  for (auto& [body, problem] : problems) {
    const Group& group = groups[first[body.index]];
    if (problem.warning || group.bodies < 2) continue;
    const Vec3 com = group.mass > 0 ? (1 / group.mass) * group.moment : Vec3{};
    const MassProblem whole = check_mass(group.mass, group.inertia + point_inertia(-group.mass, com));
    if (!whole.what.empty() && !whole.warning) continue;
    problem.warning = true;
    problem.hint = "bodies rigidly joined to it compensate for that; " + problem.hint;
  }
  return problems;
}

}  // namespace momentree
