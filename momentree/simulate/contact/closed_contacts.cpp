#include <momentree/simulate/contact/closed_contacts.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/loops/islands.hpp>
#include <momentree/dynamics/momentum.hpp>

namespace momentree {

namespace {

double excess_of_island(const ContactWorld& world, const std::vector<std::size_t>& island) {
  const std::vector<double>& r = world.workspace().contacts->rows.forces;
  double size = 1e-300, worst = -1;
  for (const std::size_t i : island)
    for (std::size_t k = 0; k < 3; ++k) size = std::max(size, std::fabs(r[3 * i + k]));
  for (const std::size_t i : island) {
    worst = std::max(worst, -r[3 * i] / size);
    const Contact& c = world.closed()[i];
    if (c.mode == Contact::Mode::stick)
      worst = std::max(worst, (std::hypot(r[3 * i + 1], r[3 * i + 2]) - c.friction * r[3 * i]) / size);
  }
  return worst;
}

}  // namespace

Vec3 slip_velocity(const ContactWorld& world, const Contact& contact) {
  const contact::Place a = world.place(contact.a), b = world.place(contact.b);
  const contact::Touch touch = contact::touch(contact.features, a, b);
  const Vec3 v = contact::relative_velocity(touch, a, b) + belt_velocity(contact, touch, a, b);
  return v - dot(v, touch.normal) * touch.normal;
}

ForceExcess force_excess(const ContactWorld& world) {
  constexpr double accuracy_of_margins = 1e-10;  // where friction is at its limit by construction
  constexpr double possible = 1e-9;  // inside the cones by this at least: if the least forces reach a cone, others are chosen
  const ContactRows& rows = world.closed_rows();
  ForceExcess worst;
  const auto note = [&](double excess, std::size_t contact) {
    if (excess > worst.excess) worst = {excess, contact};
  };
  for (const ContactRows::Group& group : rows.groups)
    if (group.shared) note(-group.margin - accuracy_of_margins, rows.of_group(group).front());
  for (const std::vector<std::size_t>& island : rows.islands()) {
    const ContactRows::Group& group = rows.groups[rows.group_of[island.front()]];
    if (group.shared) continue;
    const double excess = excess_of_island(world, island);
    note(group.redundant ? std::min(excess, -possible) : excess, island.front());
  }
  return worst;
}

std::vector<double> kinetic_by_island(const ContactWorld& world) {
  const Tree& tree = world.tree();
  Islands islands(tree);
  std::vector<double> energies(static_cast<std::size_t>(tree.bodies()), 0.0);
  std::vector<bool> touches(energies.size(), false);
  for (const Contact& c : world.closed()) islands.join(c.a, c.b);
  for (const Contact& c : world.closed()) touches[static_cast<std::size_t>(islands.of(c.a >= 0 ? c.a : c.b))] = true;
  for (const int b : tree.order()) {
    const auto island = static_cast<std::size_t>(islands.of(b));
    const Motion<double>& v = world.workspace().bodies[static_cast<std::size_t>(b)].velocity;
    if (touches[island]) energies[island] += 0.5 * dot(v, momentum(tree.link(b).body, v));
  }
  return energies;
}

std::vector<int> most_loaded(const ContactWorld& world) {
  const std::span<const Contact> closed = world.closed();
  const std::vector<double>& forces = world.workspace().contacts->rows.forces;
  if (forces.size() != 3 * closed.size()) return {};
  std::size_t worst = 0;
  const auto load = [&](std::size_t i) { return std::isfinite(forces[3 * i]) ? std::fabs(forces[3 * i]) : HUGE_VAL; };
  for (std::size_t i = 1; i < closed.size(); ++i)
    if (load(i) > load(worst)) worst = i;
  return {closed[worst].a, closed[worst].b};
}

std::vector<int> slowest_slip_of(const ContactWorld& world) {
  const std::span<const Contact> closed = world.closed();
  const auto speed = [&](const Contact& c) { return c.mode == Contact::Mode::slip ? norm(slip_velocity(world, c)) : HUGE_VAL; };
  const auto slowest = std::ranges::min_element(closed, {}, speed);
  return {slowest->a, slowest->b};
}

double next_rest(const ContactWorld& world) {
  double next = HUGE_VAL;
  for (const Contact& c : world.closed())
    if (c.settles >= 0) next = std::min(next, c.settles);
  return next;
}

}  // namespace momentree
