#include <momentree/models/import/follow_circles.hpp>

#include <algorithm>
#include <unordered_map>

namespace momentree::io {

std::vector<std::vector<int>> circles_of(const std::vector<std::pair<int, int>>& pairs) {
  std::unordered_map<int, std::vector<int>> leaders;
  for (const auto& [follower, leader] : pairs) leaders[follower].push_back(leader);
  constexpr std::size_t most = 20;
  enum class State { on_path, done };
  std::unordered_map<int, State> state;
  struct Step {
    int joint;
    std::size_t next = 0;  ///< index of the next of its leaders
  };
  std::vector<std::vector<int>> circles;
  std::vector<Step> path;
  for (const auto& [start, unused] : pairs) {
    if (!state.emplace(start, State::on_path).second) continue;
    for (path.push_back({start}); !path.empty();) {
      Step& at = path.back();
      const auto found = leaders.find(at.joint);
      if (found == leaders.end() || at.next == found->second.size()) {
        state[at.joint] = State::done;
        path.pop_back();
        continue;
      }
      const int leader = found->second[at.next++];
      const auto [known, fresh] = state.emplace(leader, State::on_path);
      if (fresh) {
        path.push_back({leader});
      } else if (known->second == State::on_path) {
        auto step = std::find_if(path.begin(), path.end(), [leader](const Step& each) { return each.joint == leader; });
        std::vector<int>& circle = circles.emplace_back();
        for (; step != path.end(); ++step) circle.push_back(step->joint);
        circle.push_back(leader);
        if (circles.size() == most) return circles;
      }
    }
  }
  return circles;
}

std::string circle_text(const std::vector<int>& circle, const std::function<std::string(int)>& name) {
  if (circle.size() == 2) return "joint " + name(circle[0]) + " follows itself";
  constexpr std::size_t most = 8;  // names listed
  std::string text = "joint " + name(circle[0]) + " follows " + name(circle[1]);
  for (std::size_t i = 2; i < circle.size(); ++i) {
    if (circle.size() > most && i == most / 2) {
      text += ", …";
      i = circle.size() - 2;
    }
    text += ", which follows " + name(circle[i]);
  }
  return text;
}

}  // namespace momentree::io
