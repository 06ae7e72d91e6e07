#include <momentree/integrate/floating_centres.hpp>

#include <momentree/joint/kinds.hpp>

namespace momentree {

namespace {

Quat rotation_at(const double* q) { return {q[3], q[4], q[5], q[6]}; }

void add(double* to, const Vec3& a) { to[0] += a.x, to[1] += a.y, to[2] += a.z; }

}  // namespace

void FloatingCentres::begin(const Tree& tree, const double* q) noexcept {
  if (revision_ != tree.revision()) {
    revision_ = tree.revision();
    all_.clear();
    for (const int b : tree.order()) {
      if (!at_centre_of_mass(tree, b)) continue;
      const Vec3 c = FreeKernels::offset<double>(tree.link(b));
      if (dot(c, c) > 0) all_.push_back({tree.first_q(b), tree.first_p(b), c, {}});
    }
  }
  for (Body& body : all_) body.start = rotation_matrix(rotation_at(q + body.q)) * body.c;
}

void FloatingCentres::add_spin(const double* q, const double* u, double* qdot) const noexcept {
  for (const Body& body : all_) {
    const double* const v = u + body.u;
    add(qdot + body.q, rotation_matrix(rotation_at(q + body.q)) * cross(Vec3{v[3], v[4], v[5]}, body.c));
  }
}

void FloatingCentres::place(double* q) const noexcept {
  for (const Body& body : all_) add(q + body.q, body.start - rotation_matrix(rotation_at(q + body.q)) * body.c);
}

void FloatingCentres::add_turn(const double* q, double* error) const noexcept {
  for (const Body& body : all_) {
    const Quat now = rotation_at(q + body.q), half = conjugate(now) * rotation_at(error + body.q);
    add(error + body.q, rotation_matrix(now) * cross(body.c, 2.0 * Vec3{half.x, half.y, half.z}));
  }
}

}  // namespace momentree
