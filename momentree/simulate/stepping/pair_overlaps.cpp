#include <algorithm>

#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/contact/contact_policy.hpp>
#include <momentree/simulate/stepping/pair_overlaps.hpp>

namespace momentree {

template <class Counts, class Depth>
std::optional<Overlap> PairOverlaps::deepest_of(Counts counts, Depth depth_of) const {
  if (!pairs_->any()) return std::nullopt;
  std::optional<Overlap> worst;
  for (const int i : pairs_->near(0, 0)) {
    const ContactPair& pair = (*pairs_)[i];
    if (!counts(pair) || pairs_->apart(pair) > 0) continue;
    const double depth = depth_of(i);
    if (depth > policy::overlapping * pairs_->size(pair) && (!worst || depth > worst->depth)) worst = overlap(i, depth);
  }
  return worst;
}

std::optional<Overlap> PairOverlaps::of_located() const {
  const auto located = [this](const ContactPair& pair) { return stepped_->handling(pair) == SteppedPairs::Handling::located; };
  return deepest_of(located, [this](int pair) { return -pairs_->gap(pair, 0).value; });
}

std::optional<Overlap> PairOverlaps::of_all() const {
  return deepest_of([](const ContactPair&) { return true; }, [this](int pair) { return pairs_->depth(pair); });
}

std::optional<Overlap> PairOverlaps::of_bodies() const {
  return deepest_of([](const ContactPair& pair) { return pair.cable < 0; }, [this](int pair) { return pairs_->depth(pair); });
}

std::optional<Overlap> PairOverlaps::with(BodyId body) const {
  const auto counts = [body](const ContactPair& pair) { return pair.a == body.index || pair.b == body.index; };
  return deepest_of(counts, [this](int pair) { return pairs_->depth(pair); });
}

double PairOverlaps::deepest() const {
  const std::optional<Overlap> worst = of_all();
  return worst ? worst->depth : 0;
}

Overlap PairOverlaps::overlap(int number, double depth) const {
  const ContactPair& pair = (*pairs_)[number];
  return {world_->name_of(pair.a), world_->name_of(pair.b), depth, pair.cable >= 0 ? pair.law_name : "", pair.a, pair.b};
}

std::vector<PairOverlaps::Parted> PairOverlaps::let_pass(const Connections& before) const {
  std::vector<Parted> all;
  if (!pairs_->any()) return all;
  std::vector<int> found;
  for (const int i : pairs_->near(0, 0)) {
    const ContactPair& pair = (*pairs_)[i];
    if (pair.cable >= 0 || !before.are_joined(pair.a, pair.b) || pairs_->apart(pair) > 0) continue;
    const contact::NearestPoints nearest = pairs_->nearest(pair);
    const double depth = std::max(pairs_->depth(i), -nearest.distance);
    if (!(depth > left_by_steps)) continue;
    found.push_back(i);
    const Parted parted{overlap(i, depth), nearest.on_one};
    const auto same = std::ranges::find_if(all, [&](const Parted& known) { return known.overlap.same_pair(parted.overlap); });
    if (same == all.end())
      all.push_back(parted);
    else if (same->overlap.depth < depth)
      *same = parted;
  }
  std::vector<int>& passing = world_->overlapping();
  passing.insert(passing.end(), found.begin(), found.end());
  std::ranges::sort(passing);
  return all;
}

void PairOverlaps::forget_apart() const {
  std::erase_if(world_->overlapping(), [this](int number) {
    const ContactPair& pair = (*pairs_)[number];
    return world_->is_gone(pair.a) || world_->is_gone(pair.b) || pairs_->are_apart(number);
  });
}

std::string Overlap::text(const char* up_to) const {
  if (!cable.empty())
    return "the ends of cable '" + cable + "' are farther apart than its length by " + up_to + detail::text(depth) + " m";
  return "'" + one + "' and '" + other + "' overlap by " + up_to + detail::text(depth) + " m";
}

std::optional<Overlap> deepest_overlap(const Model& model) {
  if (!model.has_contact()) return std::nullopt;
  World world(model, Variables::velocities);
  Evaluator evaluator = ContactWorld::evaluator_of(world);
  return ContactGeometry(world, evaluator).overlaps.of_all();
}

}  // namespace momentree
