#include <momentree/dynamics/contact_parts.hpp>

#include <momentree/dynamics/loop_system.hpp>

namespace momentree {

namespace {

std::size_t index_of(int i) { return static_cast<std::size_t>(i); }

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

void ContactParts::add_to(const std::vector<double>& x, double* packed) const {
  for (std::size_t i = 0; i < dof_.size(); ++i) packed[dof_[i]] += x[i];
}

}  // namespace momentree
