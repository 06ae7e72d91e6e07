#include <momentree/simulate/contact/contact_world.hpp>

#include <algorithm>
#include <map>

#include <momentree/dynamics/loops/islands.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

ContactsByPair::ContactsByPair(std::span<const Contact> all) {
  for (std::size_t i = 0; i < all.size(); ++i) sorted_.emplace_back(all[i].pair, i);
  std::sort(sorted_.begin(), sorted_.end());
}

std::span<const ContactsByPair::Entry> ContactsByPair::of(int pair) const {
  const auto first = std::lower_bound(sorted_.begin(), sorted_.end(), Entry{pair, 0});
  return {first, std::partition_point(first, sorted_.end(), [&](const Entry& entry) { return entry.first == pair; })};
}

const ContactRows& ContactWorld::closed_rows() const {
  world_->edit().evaluate();
  return workspace().contacts->rows;
}

void ContactWorld::place(std::span<const Contact> contacts, ContactRows& rows) const {
  locate_bodies(tree(), state(), workspace());
  place_contacts(tree(), workspace(), contacts, rows);
}

void ContactWorld::accelerate(std::span<const Contact> contacts, ContactRows& rows) const {
  momentree::accelerate(tree(), state(), workspace());
  place(contacts, rows);
  find_contact_accelerations(tree(), q(), workspace(), contacts, rows);
}

void ContactWorld::find_mobility(std::span<const Contact> contacts, ContactRows& rows) const {
  find_contact_mobility(tree(), q(), workspace(), contacts, rows);
  if (tree().has_loops()) static_cast<void>(state().edit());  // the workspace then holds no evaluation
}

contact::Place ContactWorld::place(int body) const {
  if (body < 0) return {};
  const BodyMotion& motion = world_->motions()[static_cast<std::size_t>(body)];
  return {rotation_matrix(motion.pose.rotation), motion.pose.position, motion.linear, motion.angular};
}

bool ContactWorld::can_be_taut(int spring) const {
  return model().springs()[static_cast<std::size_t>(spring)].inextensible && spring_acts(tree(), spring);
}

std::vector<std::vector<Contact>> ContactWorld::by_island(const std::vector<Contact>& contacts) const {
  Islands islands(tree());
  for (const Contact& c : contacts) islands.join(c.a, c.b);
  std::vector<std::vector<Contact>> all;
  std::map<int, std::size_t> place;
  for (const Contact& c : contacts) {
    const auto [known, first] = place.emplace(islands.of(c.a >= 0 ? c.a : c.b), all.size());
    if (first) all.emplace_back();
    all[known->second].push_back(c);
  }
  return all;
}

void ContactWorld::close(std::vector<Contact> contacts) const {
  if (contacts.empty() && closed().empty()) return;
  world_->edit().tree().edit().set_contacts(std::move(contacts));
  state().replace(0, 0, {}, 0, 0, {}, tree());
}

std::span<const ContactsByPair::Entry> ContactWorld::closed_of(int pair) const {
  if (by_pair_of_ != tree().revision()) by_pair_of_ = tree().revision(), by_pair_ = ContactsByPair(closed());
  return by_pair_.of(pair);
}

bool ContactWorld::is_closed(int pair, std::uint64_t id) const {
  return std::ranges::any_of(closed_of(pair), [&](const auto& entry) { return closed()[entry.second].id == id; });
}

}  // namespace momentree
