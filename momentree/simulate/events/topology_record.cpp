#include <momentree/simulate/events/topology_record.hpp>

#include <map>

namespace momentree {

JointRecord joint_record(const World& world, JointId joint) {
  const JointView view = world.joint(joint);
  const auto name = [&world](BodyId body) { return world.model().body_name(body); };
  return {std::string(view.name),
          view.kind,
          name(view.parent),
          name(view.child),
          view.at,
          view.child_at,
          view.axis,
          view.axis2,
          view.pitch,
          view.locked,
          view.loop};
}

std::vector<JointId> present_joints(const World& world) {
  std::vector<JointId> all;
  for (int j = 0; j < world.tree().bodies(); ++j)
    if (world.tree().carrier(j) >= 0) all.push_back({j});
  for (const JointId loop : world.loops()) all.push_back(loop);
  return all;
}

Membership::Membership(const World& world) {
  const Tree& tree = world.tree();
  mechanism_.assign(static_cast<std::size_t>(tree.bodies()), -1);
  for (const int b : tree.order()) {  // parents come before their children
    const int parent = tree.parent(b);
    if (parent >= 0) {
      mechanism_[static_cast<std::size_t>(b)] = mechanism_[static_cast<std::size_t>(parent)];
      continue;
    }
    mechanism_[static_cast<std::size_t>(b)] = static_cast<int>(names_.size());
    names_.emplace_back(world.mechanism_name({b}));
  }
}

std::vector<TopologyRecord::Moved> Membership::moved(const Membership& now) const {
  std::vector<TopologyRecord::Moved> all;
  std::map<int, std::size_t> places;  // by mechanism
  for (std::size_t b = 0; b < now.mechanism_.size(); ++b) {
    const int to = now.mechanism_[b];
    if (to < 0) continue;
    const std::string& name = now.names_[static_cast<std::size_t>(to)];
    if (b < mechanism_.size() && mechanism_[b] >= 0 && names_[static_cast<std::size_t>(mechanism_[b])] == name) continue;
    const auto [place, fresh] = places.emplace(to, all.size());
    if (fresh) all.push_back({name, {}});
    std::vector<std::pair<int, int>>& ranges = all[place->second].bodies;
    const int number = static_cast<int>(b);
    if (!ranges.empty() && ranges.back().first + ranges.back().second == number)
      ++ranges.back().second;
    else
      ranges.emplace_back(number, 1);
  }
  return all;
}

}  // namespace momentree
