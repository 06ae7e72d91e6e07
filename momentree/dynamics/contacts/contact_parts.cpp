#include <momentree/dynamics/contacts/contact_parts.hpp>

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include <momentree/contact/linear.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {

std::size_t index_of(int i) { return static_cast<std::size_t>(i); }

void normalise_quaternions(const Tree& tree, double* q) {
  for (const int b : tree.joints_with().quaternions)
    dispatch(tree.kind(b), [&](auto tag) { decltype(tag)::type::Kernels::normalise(q + tree.first_q(b)); });
}

void put_six(const Vec3& one, const Vec3& other, double* to) {
  to[0] = one.x, to[1] = one.y, to[2] = one.z, to[3] = other.x, to[4] = other.y, to[5] = other.z;
}

// A wrench on a body with which its joint's forces are zero but one, which is 1.
Force<double> wrench_along(const Tree& tree, const double* q, const Workspace<double>& workspace, int body, int dof) {
  const auto n = index_of(info(tree.kind(body)).nv);
  double E[6][6];  // by component of a motion, by degree of freedom
  for (std::size_t c = 0; c < 6; ++c) {
    double unit[6] = {};
    unit[c] = 1;
    project(tree, body, joint_state(tree, q, workspace, body), {{unit[0], unit[1], unit[2]}, {unit[3], unit[4], unit[5]}}, E[c]);
  }
  std::vector<double> squares(n * n), of(n, 0.0);
  std::vector<std::size_t> columns;
  of[index_of(dof)] = 1;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t c = 0; c < 6; ++c) squares[n * i + j] += E[c][i] * E[c][j];
  if (!contact::solve_linear(squares, of, columns, 1e-12)) return {};
  double W[6] = {};
  for (std::size_t c = 0; c < 6; ++c)
    for (std::size_t i = 0; i < n; ++i) W[c] += E[c][i] * of[i];
  return {{W[0], W[1], W[2]}, {W[3], W[4], W[5]}};
}

// Mechanisms with more have links: a chain of 56 on a floor takes a quarter of the time, one of 10,000 a thirtieth of the memory.
constexpr int most_dofs_of_rows = 60;

}  // namespace

void ContactParts::begin(const Tree& tree, contact::ManyPoints& many) {
  const std::span<const int> order = tree.order();
  ranges_.clear(), dof_.clear(), body_of_.clear();
  mechanism_of_.assign(index_of(tree.bodies()), -1), link_of_.assign(index_of(tree.bodies()), -1);
  row_.assign(index_of(tree.nv()), 0.0);
  for (int place = 0; place < static_cast<int>(order.size()); ++place) {
    const int b = order[index_of(place)];
    if (ranges_.empty() || (tree.parent(b) < 0 && !tree.has_loops())) ranges_.push_back({place, place});
    mechanism_of_[index_of(b)] = static_cast<int>(ranges_.size()) - 1;
    ranges_.back().end = place + 1, ranges_.back().dofs += info(tree.kind(b)).nv;
  }
  for (Range& range : ranges_) {
    const bool linked = !tree.has_loops() && range.dofs > most_dofs_of_rows;
    if (linked) range.first_link = static_cast<int>(body_of_.size());
    range.first_dof = static_cast<int>(dof_.size());
    for (const int b : order.subspan(index_of(range.begin), index_of(range.end - range.begin))) {
      if (linked) link_of_[index_of(b)] = static_cast<int>(body_of_.size()), body_of_.push_back(b);
      for (int i = 0; !linked && i < info(tree.kind(b)).nv; ++i) dof_.push_back(tree.first_p(b) + i);
    }
    range.end_dof = static_cast<int>(dof_.size());
  }
  link_responses_.resize(body_of_.size());
  many.clear(static_cast<int>(dof_.size()), static_cast<int>(ranges_.size()), static_cast<int>(body_of_.size()));
}

void ContactParts::find_links(const Tree& tree, const double* q, const Workspace<double>& workspace, int mechanism,
                              contact::Links& links) {
  Range& range = ranges_[index_of(mechanism)];
  if (std::exchange(range.known, true)) return;
  const int end = range.first_link + range.end - range.begin;
  find_body_responses(tree, q, workspace, range.begin, range.end, link_responses_.data() + range.first_link);
  for (int i = range.first_link; i < end; ++i) {
    contact::Link& link = links.all[index_of(i)];
    const BodyResponse& response = link_responses_[index_of(i)];
    const int parent = tree.parent(body_of_[index_of(i)]);
    link.group = mechanism, link.parent = parent < 0 ? -1 : link_of_[index_of(parent)];
    link.depth = parent < 0 ? 0 : links.all[index_of(link.parent)].depth + 1;
    for (std::size_t c = 0; c < 6; ++c) {
      put_six(response.carried[c].l, response.carried[c].h, link.carried.data() + 6 * c);
      put_six(response.moves[c].v, response.moves[c].w, link.own.data() + 6 * c);
    }
  }
  links.find_whole(range.first_link, end);
}

// At most three rows: wrenches on the body, in its kernel frame.
void ContactParts::add_link_part(const Tree& tree, const double* q, const Workspace<double>& workspace, int body,
                                 std::span<const Force<double>> rows, contact::ManyPoints& many,
                                 contact::ManyPoints::Part& part) {
  const int mechanism = mechanism_of_[index_of(body)], link = link_of_[index_of(body)];
  find_links(tree, q, workspace, mechanism, many.links);
  part = {mechanism, 6 * link, 6, many.J.size(), link};
  many.J.resize(part.at + 18, 0.0), many.Y.resize(part.at + 18, 0.0);
  const std::array<double, 36>& whole = many.links.all[index_of(link)].whole;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    double *const J = many.J.data() + part.at + 6 * k, *const Y = many.Y.data() + part.at + 6 * k;
    put_six(rows[k].l, rows[k].h, J);
    for (std::size_t c = 0; c < 6; ++c)
      for (std::size_t i = 0; i < 6; ++i) Y[i] += whole[6 * c + i] * J[c];
  }
}

// row_ of a mechanism times M⁻¹.
void ContactParts::solve(const Tree& tree, const double* q, Workspace<double>& workspace, const Range& range) {
  if (tree.has_loops())
    solve_with_loops(tree, q, workspace, row_.data());
  else
    solve_with_factors<double>(tree, q, workspace, row_.data(), range.begin, range.end);
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
                            const Contact& contact, const Wrenches& wrenches, contact::ManyPoints& many,
                            contact::ManyPoints::Part& part) {
  const Range& range = ranges_[index_of(mechanism)];
  part = {mechanism, part_begin(range), range.end_dof - range.first_dof, many.J.size()};
  const auto n = index_of(part.count);
  const int* const dof = dof_.data() + range.first_dof;
  many.J.resize(part.at + 3 * n, 0.0), many.Y.resize(part.at + 3 * n, 0.0);
  const auto in_mechanism = [&](int body) { return body >= 0 && mechanism_of_[index_of(body)] == mechanism; };
  const auto touched = [&](int body) { return in_mechanism(body) ? of_body_[index_of(body)].points : 0; };
  const int bodies[] = {contact.a, contact.b};
  if (std::max(touched(contact.a), touched(contact.b)) <= 2) {  // three solutions for the point, instead of six for a body
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t side = 0; side < 2; ++side)
        if (in_mechanism(bodies[side])) add_wrench_row(tree, q, workspace, bodies[side], wrenches[side][k], row_.data());
      double *const J = many.J.data() + part.at + k * n, *const Y = many.Y.data() + part.at + k * n;
      for (std::size_t i = 0; i < n; ++i) J[i] = row_[index_of(dof[i])];
      solve(tree, q, workspace, range);
      for (std::size_t i = 0; i < n; ++i) Y[i] = std::exchange(row_[index_of(dof[i])], 0.0);
    }
    return;
  }
  for (std::size_t side = 0; side < 2; ++side) {
    if (!in_mechanism(bodies[side])) continue;
    const double *const E = response(tree, q, workspace, bodies[side]), *const solved = E + 6 * n;
    for (std::size_t k = 0; k < 3; ++k) {
      const Force<double>& wrench = wrenches[side][k];
      const double W[6] = {wrench.l.x, wrench.l.y, wrench.l.z, wrench.h.x, wrench.h.y, wrench.h.z};
      double *const J = many.J.data() + part.at + k * n, *const Y = many.Y.data() + part.at + k * n;
      for (std::size_t c = 0; c < 6; ++c)
        for (std::size_t i = 0; i < n; ++i) J[i] += W[c] * E[c * n + i], Y[i] += W[c] * solved[c * n + i];
    }
  }
}

// The parts of a further point.
void ContactParts::add_point(const Tree& tree, const double* q, Workspace<double>& workspace, const Contact& contact,
                             const Wrenches& wrenches, contact::ManyPoints& many) {
  contact::ManyPoints::Point& point = many.points.emplace_back();
  const auto mechanism = [&](int body) { return body < 0 ? -1 : mechanism_of_[index_of(body)]; };
  const auto add = [&](std::size_t side, int body) {
    if (link_of_[index_of(body)] < 0)
      add_part(tree, q, workspace, mechanism(body), contact, wrenches, many, point.parts[side]);
    else
      add_link_part(tree, q, workspace, body, wrenches[side], many, point.parts[side]);
  };
  const int one = mechanism(contact.a), other = mechanism(contact.b);
  if (one >= 0) add(0, contact.a);
  if (other >= 0 && (other != one || link_of_[index_of(contact.b)] >= 0)) add(1, contact.b);
}

std::size_t ContactParts::add_moments(const Tree& tree, const double* q, Workspace<double>& workspace, const Contact& contact,
                                      const contact::Touch& touch, double length, contact::ManyPoints& many) {
  Wrenches wrenches{};
  Vec3 spin{};  // of a, less that of b
  for (const auto& [side, body, sign] : {std::tuple{0, contact.a, length}, {1, contact.b, -length}}) {
    if (body < 0) continue;
    const Kinematics<double>& kernel = workspace.bodies[index_of(body)];
    spin += sign * (kernel.R * kernel.velocity.w);
    for (std::size_t k = 0; k < 3; ++k) wrenches[index_of(side)][k].h = sign * transpose_times(kernel.R, along(touch, k));
  }
  add_point(tree, q, workspace, contact, wrenches, many);
  many.b.insert(many.b.end(), {dot(touch.normal, spin), dot(touch.tangent[0], spin), dot(touch.tangent[1], spin)});
  return many.points.size() - 1;
}

void ContactParts::add_points(const Tree& tree, const double* q, Workspace<double>& workspace, std::span<const Contact> contacts,
                              const ContactRows& rows, contact::ManyPoints& many) {
  count_points(tree, contacts);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    const contact::Touch& touch = rows.touches[i];
    Wrenches wrenches{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& direction = along(touch, k);
      if (c.a >= 0) wrenches[0][k] = contact_wrench(workspace, c.a, direction, touch.point);
      if (c.b >= 0) wrenches[1][k] = contact_wrench(workspace, c.b, -direction, touch.point);
    }
    add_point(tree, q, workspace, c, wrenches, many);
    const std::array<double, 9> block = many.block(i);
    for (std::size_t k = 0; k < 3; ++k) {
      const double v = rows.velocity[3 * i + k];
      const RowOfRigid left = rigid_row(tree, q, workspace, c, touch, k, block[4 * k], v);
      many.b.push_back(left.rests ? 0 : v);
      if (!left.rigid) continue;
      for (const contact::ManyPoints::Part& part : many.points[i].parts)
        for (std::size_t row = part.at + k * index_of(part.count), end = row + index_of(part.count); row < end; ++row)
          many.J[row] = many.Y[row] = 0;
    }
  }
}

void ContactParts::add_stop(const Tree& tree, const double* q, Workspace<double>& workspace, int body, int dof, double sign,
                            contact::ManyPoints& many) {
  const int mechanism = mechanism_of_[index_of(body)];
  const Range& range = ranges_[index_of(mechanism)];
  many.b.resize(many.b.size() + 3, 0.0);
  contact::ManyPoints::Point& point = many.points.emplace_back();
  if (range.first_link >= 0) {
    // A wrench between the two bodies whose part along the degree of freedom alone is not zero.
    Force<double> W = sign * wrench_along(tree, q, workspace, body, dof);
    add_link_part(tree, q, workspace, body, {&W, 1}, many, point.parts[0]);
    if (tree.parent(body) < 0) return;
    joint_transform_of(tree, q, workspace, body).inboard(W);
    W = -1.0 * W;
    return add_link_part(tree, q, workspace, tree.parent(body), {&W, 1}, many, point.parts[1]);
  }
  contact::ManyPoints::Part& part = point.parts[0];
  part = {mechanism, part_begin(range), range.end_dof - range.first_dof, many.J.size()};
  const auto n = index_of(part.count);
  many.J.resize(part.at + 3 * n, 0.0), many.Y.resize(part.at + 3 * n, 0.0);
  row_[index_of(tree.first_p(body) + dof)] = sign;
  const int* const dofs = dof_.data() + range.first_dof;
  for (std::size_t i = 0; i < n; ++i) many.J[part.at + i] = row_[index_of(dofs[i])];
  solve(tree, q, workspace, range);
  for (std::size_t i = 0; i < n; ++i) many.Y[part.at + i] = std::exchange(row_[index_of(dofs[i])], 0.0);
}

void ContactParts::add_to(const Tree& tree, const contact::ManyPoints& many, contact::LinksMotion& motion, double* packed) const {
  const double* const of_rows = motion.x.data() + 6 * body_of_.size();
  for (std::size_t i = 0; i < dof_.size(); ++i) packed[dof_[i]] += of_rows[i];
  for (const Range& range : ranges_) {
    if (!range.known) continue;
    many.links.complete(motion, mechanism_of_[index_of(body_of_[index_of(range.first_link)])]);
    for (std::size_t link = index_of(range.first_link), k = index_of(range.end - range.begin); k > 0; ++link, --k) {
      const BodyResponse& response = link_responses_[link];
      const int b = body_of_[link], parent = many.links.all[link].parent;
      double* const own = packed + tree.first_p(b);
      for (std::size_t c = 0; c < 6; ++c)
        for (int i = 0; i < info(tree.kind(b)).nv; ++i) {
          own[i] += response.own[c][index_of(i)] * motion.sum[6 * link + c];
          if (parent >= 0) own[i] += response.given[c][index_of(i)] * motion.x[6 * index_of(parent) + c];
        }
    }
  }
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
