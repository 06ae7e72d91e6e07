// The rows of contacts and their mobility, island by island: what an impulse moves depends on its own island alone.
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/dynamics/loops/islands.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>

namespace momentree {

namespace {

std::size_t place_in(int i) { return static_cast<std::size_t>(i); }

// The mechanism of each body, its part of the tree's order, and the degrees of freedom of what loops and couplings connect.
void find_mechanisms(const Tree& tree, ContactWorkspace& all) {
  if (all.mechanisms_of == tree.revision()) return;
  all.mechanisms_of = tree.revision();
  const std::span<const int> order = tree.order();
  const std::size_t bodies = place_in(tree.bodies());
  all.root_of.assign(bodies, -1), all.begin_of.assign(bodies, 0), all.end_of.assign(bodies, 0);
  all.first_of.assign(bodies, tree.nv()), all.last_of.assign(bodies, 0);
  for (std::size_t place = 0; place < order.size(); ++place) {
    const int b = order[place], parent = tree.parent(b);
    const int root = parent < 0 ? b : all.root_of[place_in(parent)];
    if (parent < 0) all.begin_of[place_in(b)] = static_cast<int>(place);
    all.root_of[place_in(b)] = root, all.end_of[place_in(root)] = static_cast<int>(place) + 1;
    all.first_of[place_in(root)] = std::min(all.first_of[place_in(root)], tree.first_p(b));
    all.last_of[place_in(root)] = std::max(all.last_of[place_in(root)], tree.first_p(b) + info(tree.kind(b)).nv);
  }
  const Islands islands(tree);
  all.island_of.assign(bodies, -1), all.dofs_of.assign(bodies + 1, 0);
  for (const int b : order) {
    all.island_of[place_in(b)] = islands.of(b);
    all.dofs_of[place_in(islands.of(b)) + 1] += place_in(info(tree.kind(b)).nv);
  }
  std::partial_sum(all.dofs_of.begin(), all.dofs_of.end(), all.dofs_of.begin());
  all.dof.resize(all.dofs_of.back());
  std::vector<std::size_t> next(all.dofs_of.begin(), all.dofs_of.end() - 1);
  for (const int b : order)
    for (int i = 0; i < info(tree.kind(b)).nv; ++i) all.dof[next[place_in(all.island_of[place_in(b)])]++] = tree.first_p(b) + i;
  all.joined.resize(bodies), all.group_of.assign(bodies, SIZE_MAX);
  std::iota(all.joined.begin(), all.joined.end(), 0);
}

// The group of each contact, and the degrees of freedom of each group, in a time that depends on these alone.
void find_groups(std::span<const Contact> contacts, ContactWorkspace& all, ContactRows& rows) {
  constexpr std::size_t pending = SIZE_MAX - 1;
  const auto group_of = [&](int island) -> std::size_t& { return all.group_of[place_in(island)]; };
  const auto joined = [&](int island) {
    while (all.joined[place_in(island)] != island) {
      int& next = all.joined[place_in(island)];
      next = all.joined[place_in(next)];
      island = next;
    }
    return island;
  };
  all.touched.clear();
  for (const Contact& c : contacts) {
    for (const int body : {c.a, c.b}) {
      if (body < 0 || group_of(all.island_of[place_in(body)]) != SIZE_MAX) continue;
      group_of(all.island_of[place_in(body)]) = pending;
      all.touched.push_back(all.island_of[place_in(body)]);
    }
    if (c.a < 0 || c.b < 0) continue;
    const auto [first, second] = std::minmax({joined(all.island_of[place_in(c.a)]), joined(all.island_of[place_in(c.b)])});
    all.joined[place_in(second)] = first;
  }
  rows.groups.clear(), rows.group_of.clear(), rows.place.clear();
  for (const Contact& c : contacts) {
    std::size_t& group = group_of(joined(all.island_of[place_in(c.a >= 0 ? c.a : c.b)]));
    if (group == pending) group = rows.groups.size(), rows.groups.emplace_back();
    rows.group_of.push_back(group), rows.place.push_back(rows.groups[group].count++);
  }
  const auto dofs_of = [&](int island) {
    return std::span(all.dof).subspan(all.dofs_of[place_in(island)],
                                      all.dofs_of[place_in(island) + 1] - all.dofs_of[place_in(island)]);
  };
  for (const int island : all.touched) rows.groups[group_of(joined(island))].dofs += dofs_of(island).size();
  std::size_t members = 0, dofs = 0, at = 0, at_A = 0;
  for (ContactRows::Group& group : rows.groups) {
    group.first = members, group.first_dof = dofs, group.at = at, group.at_A = at_A;
    members += group.count, dofs += group.dofs, at += 3 * group.count * group.dofs, at_A += 9 * group.count * group.count;
    group.dofs = 0;  // counted again below
  }
  rows.members.resize(members), rows.dof.resize(dofs);
  for (std::size_t i = 0; i < contacts.size(); ++i) rows.members[rows.groups[rows.group_of[i]].first + rows.place[i]] = i;
  for (const int island : all.touched) {
    ContactRows::Group& group = rows.groups[group_of(joined(island))];
    for (const int number : dofs_of(island)) rows.dof[group.first_dof + group.dofs++] = number;
  }
  for (const ContactRows::Group& group : rows.groups) {
    const auto first = rows.dof.begin() + static_cast<std::ptrdiff_t>(group.first_dof);
    std::sort(first, first + static_cast<std::ptrdiff_t>(group.dofs));
  }
  for (const int island : all.touched) all.joined[place_in(island)] = island, group_of(island) = SIZE_MAX;
  rows.J.assign(at, 0.0), rows.Y.assign(at, 0.0), rows.A.assign(at_A, 0.0);
}

// Rows of a group, which are found in an array packed as p.
class GroupMobility {
 public:
  GroupMobility(const Tree& tree, const double* q, Workspace<double>& workspace, std::span<const Contact> contacts,
                ContactWorkspace& all, ContactRows& rows, const ContactRows::Group& group)
      : tree_(tree), q_(q), workspace_(workspace), contacts_(contacts), all_(all), rows_(rows), group_(group) {}

  void find_J() {
    for (std::size_t place = 0; place < group_.count; ++place)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = rows_.members[group_.first + place];
        const contact::Touch& touch = rows_.touches[i];
        const Vec3& direction = along(touch, k);
        const auto add = [&](int body, double sign) {
          if (body >= 0) add_contact_row(tree_, q_, workspace_, body, direction, touch.point, sign, all_.packed.data());
        };
        add(contacts_[i].a, 1), add(contacts_[i].b, -1);
        take(row(rows_.J, 3 * place + k));
      }
  }

  void find_Y() {
    const int* const dof = rows_.dof.data() + group_.first_dof;
    for (std::size_t k = 0; k < 3 * group_.count; ++k) {
      const double* const J = row(rows_.J, k);
      for (std::size_t d = 0; d < group_.dofs; ++d) all_.packed[place_in(dof[d])] = J[d];
      if (tree_.has_loops()) {
        solve_with_loops(tree_, q_, workspace_, all_.packed.data());
      } else {
        const Contact& c = contacts_[rows_.members[group_.first + k / 3]];
        const int a = root(c.a), b = root(c.b);
        for (const int mechanism : {a, b == a ? -1 : b})
          if (mechanism >= 0)
            solve_with_factors<double>(tree_, q_, workspace_, all_.packed.data(), all_.begin_of[place_in(mechanism)],
                                       all_.end_of[place_in(mechanism)]);
      }
      take(row(rows_.Y, k));
      if (tree_.has_loops()) std::fill(all_.packed.begin(), all_.packed.end(), 0.0);
    }
  }

  void find_A() {
    const std::size_t n = 3 * group_.count;
    double* const A = rows_.A.data() + group_.at_A;
    for (std::size_t i = 0; i < group_.count; ++i) {
      const auto [first, last] = dofs_of(contacts_[rows_.members[group_.first + i]]);
      for (std::size_t j = 0; j <= i; ++j)
        for (std::size_t r = 3 * i; r < 3 * i + 3; ++r)
          for (std::size_t c = 3 * j; c < 3 * j + 3; ++c) {
            const double *const one = row(rows_.J, r), *const other = row(rows_.Y, c);
            A[r * n + c] = A[c * n + r] = std::inner_product(one + first, one + last, other + first, 0.0);
          }
    }
    for (std::size_t r = 0; r < n; ++r) {
      const std::size_t i = rows_.members[group_.first + r / 3], of_all = 3 * i + r % 3;
      const RowOfRigid left =
          rigid_row(tree_, q_, workspace_, contacts_[i], rows_.touches[i], r % 3, A[r * n + r], rows_.velocity[of_all]);
      if (!left.rigid) continue;
      for (std::size_t k = 0; k < n; ++k) A[r * n + k] = A[k * n + r] = 0;
      std::fill_n(row(rows_.J, r), group_.dofs, 0.0), std::fill_n(row(rows_.Y, r), group_.dofs, 0.0);
      if (!left.rests) continue;
      rows_.velocity[of_all] = 0;
      if (rows_.acceleration.size() == 3 * contacts_.size()) rows_.acceleration[of_all] = 0;
    }
  }

 private:
  double* row(std::vector<double>& of, std::size_t k) const { return of.data() + group_.at + k * group_.dofs; }
  int root(int body) const { return body < 0 ? -1 : all_.root_of[place_in(body)]; }
  // Moves what is in the array to a row.
  void take(double* to) {
    const int* const dof = rows_.dof.data() + group_.first_dof;
    for (std::size_t d = 0; d < group_.dofs; ++d) to[d] = std::exchange(all_.packed[place_in(dof[d])], 0.0);
  }
  // J of a contact is zero beyond the numbers of its mechanisms.
  std::pair<std::size_t, std::size_t> dofs_of(const Contact& c) const {
    if (tree_.has_loops()) return {0, group_.dofs};
    const int a = root(c.a), b = root(c.b), one = std::max(a, b), other = std::min(a, b) < 0 ? one : std::min(a, b);
    const auto begin = rows_.dof.begin() + static_cast<std::ptrdiff_t>(group_.first_dof),
               end = begin + static_cast<std::ptrdiff_t>(group_.dofs);
    const auto place = [&](int number) { return static_cast<std::size_t>(std::lower_bound(begin, end, number) - begin); };
    return {place(std::min(all_.first_of[place_in(one)], all_.first_of[place_in(other)])),
            place(std::max(all_.last_of[place_in(one)], all_.last_of[place_in(other)]))};
  }

  const Tree& tree_;
  const double* q_;
  Workspace<double>& workspace_;
  std::span<const Contact> contacts_;
  ContactWorkspace& all_;
  ContactRows& rows_;
  const ContactRows::Group& group_;
};

}  // namespace

void find_contact_mobility(const Tree& tree, const double* q, Workspace<double>& workspace, std::span<const Contact> contacts,
                           ContactRows& rows) {
  ContactWorkspace& all = contact_memory(workspace);
  find_mechanisms(tree, all);
  find_groups(contacts, all, rows);
  if (all.packed.size() != place_in(tree.nv())) all.packed.assign(place_in(tree.nv()), 0.0);
  const auto of = [&](const ContactRows::Group& group) { return GroupMobility(tree, q, workspace, contacts, all, rows, group); };
  for (const ContactRows::Group& group : rows.groups) of(group).find_J();  // the solutions with loops leave no evaluation
  for (const ContactRows::Group& group : rows.groups) of(group).find_Y(), of(group).find_A();
}

double ContactRows::mobility(std::size_t row, std::size_t column) const {
  const std::size_t i = row / 3, j = column / 3;
  if (group_of[i] != group_of[j]) return 0;
  const Group& group = groups[group_of[i]];
  return A[group.at_A + 3 * group.count * (3 * place[i] + row % 3) + 3 * place[j] + column % 3];
}

std::vector<double> ContactRows::matrix() const {
  const std::size_t n = 3 * contacts();
  std::vector<double> all(n * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) all[i * n + j] = mobility(i, j);
  return all;
}

void ContactRows::add_row(const std::vector<double>& of, std::size_t row, double factor, double* packed) const {
  const Group& group = groups[group_of[row / 3]];
  const double* const numbers = of.data() + group.at + (3 * place[row / 3] + row % 3) * group.dofs;
  const int* const to = dof.data() + group.first_dof;
  for (std::size_t d = 0; d < group.dofs; ++d) packed[to[d]] += factor * numbers[d];
}

ContactRows ContactRows::some(const std::vector<std::size_t>& numbers) const {
  ContactRows rows;
  const std::size_t n = 3 * touches.size();
  const auto copy = [&](const std::vector<double>& all, std::vector<double>& to) {
    if (all.size() != n) return;
    for (const std::size_t i : numbers)
      for (std::size_t k = 0; k < 3; ++k) to.push_back(all[3 * i + k]);
  };
  copy(velocity, rows.velocity), copy(acceleration, rows.acceleration), copy(forces, rows.forces);
  for (const std::size_t i : numbers) {
    rows.touches.push_back(touches[i]);
    if (slip.size() == touches.size()) rows.slip.push_back(slip[i]);
  }
  rows.groups.push_back({.count = numbers.size()});
  rows.group_of.assign(numbers.size(), 0);
  rows.members.resize(numbers.size());
  std::iota(rows.members.begin(), rows.members.end(), std::size_t{0});
  rows.place = rows.members;
  for (const std::size_t i : numbers)
    for (std::size_t k = 0; k < 3; ++k)
      for (const std::size_t j : numbers)
        for (std::size_t l = 0; l < 3; ++l) rows.A.push_back(mobility(3 * i + k, 3 * j + l));
  return rows;
}

std::vector<std::vector<std::size_t>> ContactRows::islands() const {
  std::vector<std::vector<std::size_t>> all;
  std::vector<bool> taken(contacts(), false);
  const auto connected = [&](std::size_t i, std::size_t j) {
    for (std::size_t k = 0; k < 9; ++k)
      if (mobility(3 * i + k / 3, 3 * j + k % 3) != 0) return true;
    return false;
  };
  for (std::size_t first = 0; first < contacts(); ++first) {
    if (taken[first]) continue;
    std::vector<std::size_t> island{first};
    taken[first] = true;
    for (std::size_t next = 0; next < island.size(); ++next)
      for (const std::size_t j : of_group(groups[group_of[first]]))
        if (!taken[j] && connected(island[next], j)) taken[j] = true, island.push_back(j);
    std::sort(island.begin(), island.end());
    all.push_back(std::move(island));
  }
  return all;
}

}  // namespace momentree
