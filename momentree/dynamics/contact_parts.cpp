#include <momentree/dynamics/contact_parts.hpp>

#include <momentree/dynamics/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {

std::size_t index_of(int i) { return static_cast<std::size_t>(i); }

void normalise_quaternions(const Tree& tree, double* q) {
  for (const int b : tree.quaternion_joints())
    dispatch(tree.kind(b), [&](auto tag) { decltype(tag)::type::Kernels::normalise(q + tree.first_q(b)); });
}

}  // namespace

void ContactParts::number(const Tree& tree) {
  const std::span<const int> order = tree.order();
  ranges_.clear(), dof_.clear();
  mechanism_of_.assign(index_of(tree.bodies()), -1);
  row_.assign(index_of(tree.nv()), 0.0);
  for (std::size_t place = 0; place < order.size(); ++place) {
    const int b = order[place];
    if (ranges_.empty() || (tree.parent(b) < 0 && !tree.has_loops())) {
      const int dof = static_cast<int>(dof_.size());
      ranges_.push_back({static_cast<int>(place), 0, dof, 0});
    }
    for (int i = 0; i < info(tree.kind(b)).nv; ++i) dof_.push_back(tree.first_p(b) + i);
    mechanism_of_[index_of(b)] = static_cast<int>(ranges_.size()) - 1;
    ranges_.back().end = static_cast<int>(place) + 1, ranges_.back().end_dof = static_cast<int>(dof_.size());
  }
}

void ContactParts::add_part(const Tree& tree, const double* q, Workspace<double>& workspace, int mechanism,
                            const Contact& contact, const contact::Touch& touch, contact::ManyPoints& many,
                            contact::ManyPoints::Part& part) {
  const Range& range = ranges_[index_of(mechanism)];
  part = {mechanism, range.first_dof, range.end_dof - range.first_dof, many.J.size()};
  const auto n = index_of(part.count);
  many.J.resize(part.at + 3 * n), many.Y.resize(part.at + 3 * n);
  const int* const dof = dof_.data() + part.first;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& along = k == 0 ? touch.normal : touch.tangent[k - 1];
    for (const auto& [body, sign] : {std::pair{contact.a, 1.0}, {contact.b, -1.0}})
      if (body >= 0 && mechanism_of_[index_of(body)] == mechanism)
        add_contact_row(tree, q, workspace, body, along, touch.point, sign, row_.data());
    double *const J = many.J.data() + part.at + k * n, *const Y = many.Y.data() + part.at + k * n;
    for (std::size_t i = 0; i < n; ++i) J[i] = row_[index_of(dof[i])];
    if (tree.has_loops())
      solve_with_loops(tree, q, workspace, row_.data());
    else
      solve_mechanism<double>(tree, q, workspace, row_.data(), range.begin, range.end);
    for (std::size_t i = 0; i < n; ++i) Y[i] = std::exchange(row_[index_of(dof[i])], 0.0);
  }
}

void ContactParts::add_points(const Tree& tree, const double* q, Workspace<double>& workspace, std::span<const Contact> contacts,
                              const ContactRows& rows, contact::ManyPoints& many) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    contact::ManyPoints::Point& point = many.points.emplace_back();
    const int one = c.a < 0 ? -1 : mechanism_of_[index_of(c.a)], other = c.b < 0 ? -1 : mechanism_of_[index_of(c.b)];
    if (one >= 0) add_part(tree, q, workspace, one, c, rows.touches[i], many, point.parts[0]);
    if (other >= 0 && other != one) add_part(tree, q, workspace, other, c, rows.touches[i], many, point.parts[1]);
    for (std::size_t k = 0; k < 3; ++k) many.b.push_back(rows.velocity[3 * i + k]);
  }
}

void ContactParts::add_stop(const Tree& tree, const double* q, Workspace<double>& workspace, int body, int dof, double sign,
                            contact::ManyPoints& many) {
  const int mechanism = mechanism_of_[index_of(body)];
  const Range& range = ranges_[index_of(mechanism)];
  contact::ManyPoints::Part& part = many.points.emplace_back().parts[0];
  part = {mechanism, range.first_dof, range.end_dof - range.first_dof, many.J.size()};
  const auto n = index_of(part.count);
  many.J.resize(part.at + 3 * n, 0.0), many.Y.resize(part.at + 3 * n, 0.0), many.b.resize(many.b.size() + 3, 0.0);
  row_[index_of(tree.first_p(body) + dof)] = sign;
  const int* const dofs = dof_.data() + part.first;
  for (std::size_t i = 0; i < n; ++i) many.J[part.at + i] = row_[index_of(dofs[i])];
  if (tree.has_loops())
    solve_with_loops(tree, q, workspace, row_.data());
  else
    solve_mechanism<double>(tree, q, workspace, row_.data(), range.begin, range.end);
  for (std::size_t i = 0; i < n; ++i) many.Y[part.at + i] = std::exchange(row_[index_of(dofs[i])], 0.0);
}

void ContactParts::add_to(const std::vector<double>& x, double* packed) const {
  for (std::size_t i = 0; i < dof_.size(); ++i) packed[dof_[i]] += x[i];
}

void MomentumKeepingDisplacement::apply(const Tree& tree, double t, const double* shift, double* q, double* u,
                                        Workspace<double>& workspace) {
  kept_.resize(index_of(tree.bodies()));
  const auto place = [&] {
    sweep_velocities<double, true>(tree, q, u, workspace);
    locate_stage(tree, q, workspace);
  };
  const auto centre = [&](int b) { return (1 / tree.link(b).body.m) * tree.link(b).body.mc; };
  place();
  for (const int b : tree.order()) {
    const Kinematics<double>& k = workspace.bodies[index_of(b)];
    const RigidMass& mass = tree.link(b).body;
    const Force<double> own = momentum(mass, k.velocity);
    kept_[index_of(b)] = {k.R * own.l, mass.m > 0 ? k.R * (own.h - cross(centre(b), own.l)) : k.R * own.h};
  }
  detail::displace(tree, shift, 1, q);
  normalise_quaternions(tree, q);
  place();
  for (const int b : tree.order()) {
    const Mat3& R = workspace.bodies[index_of(b)].R;
    const Force<double>& kept = kept_[index_of(b)];
    const Vec3 l = transpose_times(R, kept.l);
    workspace.carried[index_of(b)] = {l, transpose_times(R, kept.h) + (tree.link(b).body.m > 0 ? cross(centre(b), l) : Vec3{})};
  }
  project_velocities(tree, q, u, workspace, t);
}

}  // namespace momentree
