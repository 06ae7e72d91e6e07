#include <momentree/dynamics/contact_parts.hpp>

#include <algorithm>
#include <array>
#include <utility>

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

// row_ of a mechanism times M⁻¹.
void ContactParts::solve(const Tree& tree, const double* q, Workspace<double>& workspace, const Range& range) {
  if (tree.has_loops())
    solve_with_loops(tree, q, workspace, row_.data());
  else
    solve_mechanism<double>(tree, q, workspace, row_.data(), range.begin, range.end);
}

void ContactParts::count_points(const Tree& tree, std::span<const Contact> contacts) {
  of_body_.assign(index_of(tree.bodies()), {});
  responses_.clear();
  for (const Contact& c : contacts)
    for (const int body : {c.a, c.b})
      if (body >= 0) ++of_body_[index_of(body)].points;
}

const double* ContactParts::response(const Tree& tree, const double* q, Workspace<double>& workspace, int body) {
  Response& known = of_body_[index_of(body)];
  if (known.at != SIZE_MAX) return responses_.data() + known.at;
  const Range& range = ranges_[index_of(mechanism_of_[index_of(body)])];
  const auto n = index_of(range.end_dof - range.first_dof);
  const int* const dof = dof_.data() + range.first_dof;
  known.at = responses_.size();
  responses_.resize(known.at + 12 * n);
  for (std::size_t k = 0; k < 6; ++k) {
    double unit[6] = {};
    unit[k] = 1;
    add_wrench_row(tree, q, workspace, body, {{unit[0], unit[1], unit[2]}, {unit[3], unit[4], unit[5]}}, row_.data());
    double *const E = responses_.data() + known.at + k * n, *const solved = E + 6 * n;
    for (std::size_t i = 0; i < n; ++i) E[i] = row_[index_of(dof[i])];
    solve(tree, q, workspace, range);
    for (std::size_t i = 0; i < n; ++i) solved[i] = std::exchange(row_[index_of(dof[i])], 0.0);
  }
  return responses_.data() + known.at;
}

void ContactParts::add_part(const Tree& tree, const double* q, Workspace<double>& workspace, int mechanism,
                            const Contact& contact, const contact::Touch& touch, contact::ManyPoints& many,
                            contact::ManyPoints::Part& part) {
  const Range& range = ranges_[index_of(mechanism)];
  part = {mechanism, range.first_dof, range.end_dof - range.first_dof, many.J.size()};
  const auto n = index_of(part.count);
  many.J.resize(part.at + 3 * n, 0.0), many.Y.resize(part.at + 3 * n, 0.0);
  const auto in_mechanism = [&](int body) { return body >= 0 && mechanism_of_[index_of(body)] == mechanism; };
  const auto touched = [&](int body) { return in_mechanism(body) ? of_body_[index_of(body)].points : 0; };
  const std::array<std::pair<int, double>, 2> bodies{{{contact.a, 1.0}, {contact.b, -1.0}}};
  const auto along = [&](std::size_t k) -> const Vec3& { return k == 0 ? touch.normal : touch.tangent[k - 1]; };
  if (std::max(touched(contact.a), touched(contact.b)) <= 2) {  // three solutions for the point, instead of six for a body
    const int* const dof = dof_.data() + part.first;
    for (std::size_t k = 0; k < 3; ++k) {
      for (const auto& [body, sign] : bodies)
        if (in_mechanism(body)) add_contact_row(tree, q, workspace, body, along(k), touch.point, sign, row_.data());
      double *const J = many.J.data() + part.at + k * n, *const Y = many.Y.data() + part.at + k * n;
      for (std::size_t i = 0; i < n; ++i) J[i] = row_[index_of(dof[i])];
      solve(tree, q, workspace, range);
      for (std::size_t i = 0; i < n; ++i) Y[i] = std::exchange(row_[index_of(dof[i])], 0.0);
    }
    return;
  }
  for (const auto& [body, sign] : bodies) {
    if (!in_mechanism(body)) continue;
    const double *const E = response(tree, q, workspace, body), *const solved = E + 6 * n;
    for (std::size_t k = 0; k < 3; ++k) {
      const Force<double> wrench = contact_wrench(workspace, body, sign * along(k), touch.point);
      const double W[6] = {wrench.l.x, wrench.l.y, wrench.l.z, wrench.h.x, wrench.h.y, wrench.h.z};
      double *const J = many.J.data() + part.at + k * n, *const Y = many.Y.data() + part.at + k * n;
      for (std::size_t c = 0; c < 6; ++c)
        for (std::size_t i = 0; i < n; ++i) J[i] += W[c] * E[c * n + i], Y[i] += W[c] * solved[c * n + i];
    }
  }
}

void ContactParts::add_points(const Tree& tree, const double* q, Workspace<double>& workspace, std::span<const Contact> contacts,
                              const ContactRows& rows, contact::ManyPoints& many) {
  count_points(tree, contacts);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    contact::ManyPoints::Point& point = many.points.emplace_back();
    const int one = c.a < 0 ? -1 : mechanism_of_[index_of(c.a)], other = c.b < 0 ? -1 : mechanism_of_[index_of(c.b)];
    if (one >= 0) add_part(tree, q, workspace, one, c, rows.touches[i], many, point.parts[0]);
    if (other >= 0 && other != one) add_part(tree, q, workspace, other, c, rows.touches[i], many, point.parts[1]);
    for (std::size_t k = 0; k < 3; ++k) {
      double mobility = 0;
      for (const contact::ManyPoints::Part& part : point.parts)
        for (std::size_t row = part.at + k * index_of(part.count), end = row + index_of(part.count); row < end; ++row)
          mobility += many.J[row] * many.Y[row];
      const double v = rows.velocity[3 * i + k];
      const RowOfRigid left = rigid_row(tree, q, workspace, c, rows.touches[i], k, mobility, v);
      many.b.push_back(left.rests ? 0 : v);
      if (!left.rigid) continue;
      for (const contact::ManyPoints::Part& part : point.parts)
        for (std::size_t row = part.at + k * index_of(part.count), end = row + index_of(part.count); row < end; ++row)
          many.J[row] = many.Y[row] = 0;
    }
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
  solve(tree, q, workspace, range);
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
  if (tree.has_loops()) {
    detail::place_loops(tree, q, workspace, true);
    carry_armatures(tree, workspace);
  }
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
