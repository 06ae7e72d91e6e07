// The springs of a world.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/forces/springs.hpp>
#include <momentree/simulate/world/world.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

void World::put_springs(const std::vector<Topology::SpringChange>& changes) {
  for (const Topology::SpringChange& change : changes) {
    tree_.edit().set_spring_law(change.spring, change.law);
    if (change.broken) tree_.edit().break_spring(change.spring);
  }
}

int World::find_spring(std::string_view name) const {
  const std::vector<Spring>& springs = model_.springs();
  for (std::size_t s = 0; s < springs.size(); ++s)
    if (springs[s].name == name) return static_cast<int>(s);
  return -1;
}

int World::find_spring(std::string_view name, std::atomic<int>& number) const {
  const std::vector<Spring>& springs = model_.springs();
  const int last = number.load(std::memory_order_relaxed);
  if (last >= 0 && static_cast<std::size_t>(last) < springs.size() && springs[static_cast<std::size_t>(last)].name == name)
    return last;
  const int found = springs.empty() ? -1 : find_spring(name);
  number.store(found, std::memory_order_relaxed);
  return found;
}

SpringView World::spring(SpringId number) const {
  const int s = number.index;
  MT_REQUIRE(s >= 0 && s < tree_.springs().count(), "the world has a spring of that number");
  const Spring& spring = model_.springs()[static_cast<std::size_t>(s)];
  SpringView view{spring.name, spring.from, spring.to, tree_.springs().law(s), !spring_acts(tree_, s), 0, 0,
                  0,           {},          {},        spring.inextensible};
  for (const SpringEnd* end : {&spring.from, &spring.to})
    if (end->body != ground && !alive(end->body)) return view;
  locate_bodies(tree_, state_, workspace_);
  const SpringMotion motion = spring_motion(tree_, workspace_, s);
  view.length = motion.length, view.rate = motion.rate;
  view.place_of_from = motion.from, view.place_of_to = motion.to;
  if (spring.inextensible)
    view.tension = view.broken ? 0 : cable_tension(s);
  else if (!view.broken && motion.length > 0)
    view.tension = view.law.tension(motion.length, motion.rate);
  return view;
}

}  // namespace momentree
