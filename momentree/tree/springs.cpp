// Springs of a tree: the model's, those that broke, and laws that changes set. No change of them moves a coordinate.
#include <algorithm>
#include <cmath>

#include <momentree/tree/edit.hpp>

namespace momentree {

void Tree::put_springs(const std::vector<Topology::SpringChange>& changes) {
  springs_.states.resize(springs_.size());
  for (std::size_t s = 0; s < springs_.states.size(); ++s) springs_.states[s] = {static_cast<int>(s), false, law_of(springs_[s])};
  for (const Topology::SpringChange& change : changes) springs_.states[at(change.spring)] = change;
}

bool has_spring_strengths(const Tree& tree) {
  const auto& all = tree.springs().states;
  return std::any_of(all.begin(), all.end(), [&tree](const Topology::SpringChange& s) {
    return std::isfinite(s.law.strength) && spring_acts(tree, s.spring);
  });
}

void Tree::Edit::break_spring(int spring) {
  MT_REQUIRE(!tree_.springs_.broken(spring), "the spring is not broken");
  tree_.springs_.states[at(spring)].broken = true;
  tree_.list_loaded_bodies();
  tree_.revision_.renew();
}

void Tree::Edit::set_spring_law(int spring, const SpringLaw& law) {
  MT_REQUIRE(!tree_.springs_.broken(spring), "the spring is not broken");
  tree_.springs_.states[at(spring)].law = law;
  tree_.revision_.renew();
}

void Tree::Edit::set_contacts(std::vector<Contact> contacts) {
  for (const Contact& c : contacts)
    MT_REQUIRE((c.a < 0 || tree_.alive(c.a)) && (c.b < 0 || tree_.alive(c.b)) && c.a != c.b,
               "a contact is between two bodies of the tree");
  tree_.contacts_ = std::move(contacts);
  tree_.list_loaded_bodies();
  tree_.revision_.renew();
}

}  // namespace momentree
