// Pairs of solids that overlap, and those that pass through each other because the joint between their bodies ended while they
// did.
#include <algorithm>
#include <cmath>

#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/contacts_impl.hpp>

namespace momentree {

std::optional<Overlap> Contacts::overlap() { return deepest(-1); }
std::optional<Overlap> Contacts::overlap_of_all() { return deepest(-1, true); }
std::optional<Overlap> Contacts::overlap_of_bodies() { return deepest(-1, true, false); }
double Contacts::deepest_of_all() {
  const std::optional<Overlap> worst = overlap_of_all();
  return worst ? worst->depth : 0;
}
std::optional<Overlap> Contacts::overlap_with(BodyId body) { return deepest(body.index, true); }

// How deep a pair overlaps (m), also where bodies cross each other so that no feature of one is inside the other.
double Contacts::depth_of(const Pair& pair, int number) const {
  double depth = -gap_of(number, 0).value;
  if (pair.cable >= 0 || pair.other->plane || pair.one->solid.faces.empty() || pair.other->solid.faces.empty()) return depth;
  found_candidates_.clear();
  overlap_.find(pair.one->solid, place(pair.a), pair.other->solid, place(pair.b), 0, found_candidates_);
  for (const contact::Candidate& found : found_candidates_) depth = std::max(depth, -found.gap);
  return depth;
}

bool Contacts::are_apart(int number) const {
  const Pair& pair = pairs_[static_cast<std::size_t>(number)];
  const double distance = distance_to(pair.one->solid, place(pair.a), *pair.other, place(pair.b)).distance;
  return distance > policy::touching_within * pair.size(*this);
}

void Contacts::forget_apart() {
  std::erase_if(world_->overlapping_, [this](int number) {
    const Pair& pair = pairs_[static_cast<std::size_t>(number)];
    return is_gone(pair.a) || is_gone(pair.b) || are_apart(number);
  });
}

std::vector<Contacts::Parted> Contacts::let_pass(const Connections& before) {
  std::vector<Parted> all;
  if (!any()) return all;
  std::vector<int> found;
  for (const int i : near_pairs(0, 0)) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    if (pair.cable >= 0 || !before.are_joined(pair.a, pair.b) || apart(pair) > 0) continue;
    const contact::NearestPoints nearest = distance_to(pair.one->solid, place(pair.a), *pair.other, place(pair.b));
    const double depth = std::max(depth_of(pair, i), -nearest.distance);
    if (!(depth > left_by_steps)) continue;
    found.push_back(i);
    const Parted parted{overlap_of(i, depth), nearest.on_one};
    const auto same =
        std::find_if(all.begin(), all.end(), [&](const Parted& known) { return known.overlap.same_pair(parted.overlap); });
    if (same == all.end())
      all.push_back(parted);
    else if (same->overlap.depth < depth)
      *same = parted;
  }
  std::vector<int>& passing = world_->overlapping_;
  passing.insert(passing.end(), found.begin(), found.end());
  std::sort(passing.begin(), passing.end());
  return all;
}

// Of that body, or of all bodies if it is negative: then of located contacts, or of all.
std::optional<Overlap> Contacts::deepest(int body, bool all, bool cables) {
  if (!any()) return std::nullopt;
  std::optional<Overlap> worst;
  for (const int i : near_pairs(0, 0)) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    if (body >= 0 ? pair.a != body && pair.b != body : !all && handling(pair) != Handling::located) continue;
    if ((pair.cable >= 0 && !cables) || apart(pair) > 0) continue;
    const double depth = all ? depth_of(pair, i) : -gap_of(i, 0).value;
    if (depth > policy::overlapping * pair.size(*this) && (!worst || depth > worst->depth)) worst = overlap_of(i, depth);
  }
  return worst;
}

Overlap Contacts::overlap_of(int number, double depth) const {
  const Pair& pair = pairs_[static_cast<std::size_t>(number)];
  return {name_of(pair.a), name_of(pair.b), depth, pair.cable >= 0 ? pair.law_name : "", pair.a, pair.b};
}

std::string Overlap::text(const char* up_to) const {
  if (!cable.empty())
    return "the ends of cable '" + cable + "' are farther apart than its length by " + up_to + detail::text(depth) + " m";
  return "'" + one + "' and '" + other + "' overlap by " + up_to + detail::text(depth) + " m";
}

std::optional<Overlap> deepest_overlap(const Model& model) {
  if (!model.has_contact()) return std::nullopt;
  World world(model, Variables::velocities);
  return Contacts::overlap_of(world);
}

std::optional<Overlap> Contacts::overlap_of(World& world) {
  Evaluator evaluate(world.tree_, world.workspace_);
  return Contacts(world, evaluate, 1e-10).overlap_of_all();
}

}  // namespace momentree
