// Springs of a tree: the model's, those that broke, and laws that changes set. No change of them moves a coordinate.
#include <algorithm>

#include <momentree/tree/tree.hpp>

namespace momentree {

void Tree::put_springs(const std::vector<Topology::SpringChange>& changes) {
  spring_states_.resize(springs().size());
  for (std::size_t s = 0; s < spring_states_.size(); ++s) spring_states_[s] = {static_cast<int>(s), false, law_of(springs()[s])};
  for (const Topology::SpringChange& change : changes) spring_states_[at(change.spring)] = change;
}

bool Tree::has_spring_strengths() const {
  return std::any_of(spring_states_.begin(), spring_states_.end(),
                     [this](const Topology::SpringChange& s) { return std::isfinite(s.law.strength) && spring_acts(s.spring); });
}

void Tree::break_spring(int spring) {
  MT_REQUIRE(!spring_broken(spring), "the spring is not broken");
  spring_states_[at(spring)].broken = true;
  list_loaded_bodies();
  revision_.renew();
}

void Tree::set_spring_law(int spring, const SpringLaw& law) {
  MT_REQUIRE(!spring_broken(spring), "the spring is not broken");
  spring_states_[at(spring)].law = law;
  revision_.renew();
}

void Tree::set_contacts(std::vector<Contact> contacts) {
  for (const Contact& c : contacts)
    MT_REQUIRE((c.a < 0 || alive(c.a)) && (c.b < 0 || alive(c.b)) && c.a != c.b, "a contact is between two bodies of the tree");
  contacts_ = std::move(contacts);
  list_loaded_bodies();
  revision_.renew();
}

}  // namespace momentree
