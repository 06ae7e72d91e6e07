#include <momentree/models/import/spanning.hpp>

#include <algorithm>
#include <limits>
#include <utility>

namespace momentree::io {

namespace {

class Spanner {
 public:
  Spanner(std::size_t links, const std::vector<SpanningEnds>& joints)
      : links_(links), joints_(joints), inboard_(links), outboard_(links), depth_(links, unreached), chosen_(links, none) {
    for (std::size_t j = 0; j < joints.size(); ++j) {
      inboard_[at(joints[j].child)].push_back(j);
      if (joints[j].parent >= 0) outboard_[at(joints[j].parent)].push_back(j);
    }
  }

  std::vector<int> span() {
    measure();
    for (std::size_t link = 0; link < links_; ++link)
      if (depth_[link] > 0) chosen_[link] = best(link, false);
    // Preferring rows to depth can make a cycle. Its links then take the joint nearest to the root, which can't.
    constexpr int most_rounds = 8;
    for (int round = 0; round < most_rounds; ++round) {
      const std::vector<std::size_t> cyclic = on_cycles();
      if (cyclic.empty()) return result();
      for (const std::size_t link : cyclic) chosen_[link] = best(link, true);
    }
    for (std::size_t link = 0; link < links_; ++link)
      if (depth_[link] > 0) chosen_[link] = best(link, true);
    return result();
  }

 private:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  static constexpr int unreached = std::numeric_limits<int>::max();
  static std::size_t at(int link) { return static_cast<std::size_t>(link); }

  int depth_of_parent(std::size_t joint) const { return joints_[joint].parent < 0 ? 0 : depth_[at(joints_[joint].parent)]; }

  // Number of joints from a root, at least: roots have depth 0, as does the ground.
  void measure() {
    std::vector<std::size_t> front;
    for (const SpanningEnds& each : joints_)
      if (each.parent < 0 && depth_[at(each.child)] == unreached) depth_[at(each.child)] = 1, front.push_back(at(each.child));
    for (std::size_t link = 0; link < links_; ++link)
      if (inboard_[link].empty()) depth_[link] = 0, front.push_back(link);
    // The roots first: a queue in order of depth.
    std::stable_sort(front.begin(), front.end(), [this](std::size_t a, std::size_t b) { return depth_[a] < depth_[b]; });
    reach(std::move(front));
    front = cycle_roots();
    for (const std::size_t link : front) depth_[link] = 0;
    reach(std::move(front));
  }

  void reach(std::vector<std::size_t> queue) {
    for (std::size_t i = 0; i < queue.size(); ++i)
      for (const std::size_t joint : outboard_[queue[i]]) {
        const std::size_t child = at(joints_[joint].child);
        if (depth_[child] <= depth_[queue[i]] + 1) continue;
        depth_[child] = depth_[queue[i]] + 1;
        queue.push_back(child);
      }
  }

  // Among links that no root leads to, the first of each strongly connected component that no other component leads to
  // (Kosaraju).
  std::vector<std::size_t> cycle_roots() const {
    std::vector<char> seen(links_, 0);
    std::vector<std::size_t> finished, stack;
    std::vector<std::size_t> next(links_, 0);
    for (std::size_t start = 0; start < links_; ++start) {
      if (depth_[start] != unreached || seen[start]) continue;
      seen[start] = 1, stack.push_back(start);
      while (!stack.empty()) {
        const std::size_t link = stack.back();
        if (next[link] == outboard_[link].size()) {
          finished.push_back(link), stack.pop_back();
          continue;
        }
        const std::size_t child = at(joints_[outboard_[link][next[link]++]].child);
        if (depth_[child] == unreached && !seen[child]) seen[child] = 1, stack.push_back(child);
      }
    }
    // Against the direction of the joints, from the last to finish: each search finds one component, sources first.
    std::vector<std::size_t> roots;
    std::fill(seen.begin(), seen.end(), 0);
    for (auto last = finished.rbegin(); last != finished.rend(); ++last) {
      if (seen[*last]) continue;
      std::size_t first = *last;
      bool source = true;
      std::vector<std::size_t> part{*last};
      seen[*last] = 2;  // in this component
      for (std::size_t i = 0; i < part.size(); ++i) {
        first = std::min(first, part[i]);
        for (const std::size_t joint : inboard_[part[i]]) {
          const std::size_t parent = at(joints_[joint].parent);
          source = source && seen[parent] != 1;
          if (!seen[parent]) seen[parent] = 2, part.push_back(parent);
        }
      }
      for (const std::size_t link : part) seen[link] = 1;
      if (source) roots.push_back(first);
    }
    return roots;
  }

  std::size_t best(std::size_t link, bool nearest) const {
    std::size_t best = none;
    for (const std::size_t joint : inboard_[link]) {
      if (best == none) {
        best = joint;
        continue;
      }
      const int rows = joints_[joint].rows - joints_[best].rows, depth = depth_of_parent(best) - depth_of_parent(joint);
      if (nearest ? depth > 0 || (depth == 0 && rows > 0) : rows > 0 || (rows == 0 && depth > 0)) best = joint;
    }
    return best;
  }

  std::vector<std::size_t> on_cycles() const {
    enum State : char { unseen, walking, done };
    std::vector<char> state(links_, unseen);
    std::vector<std::size_t> cyclic, path;
    for (std::size_t start = 0; start < links_; ++start) {
      path.clear();
      std::size_t link = start;
      while (link != none && state[link] == unseen) {
        state[link] = walking;
        path.push_back(link);
        const int parent = chosen_[link] == none ? -1 : joints_[chosen_[link]].parent;
        link = parent < 0 ? none : at(parent);
      }
      if (link != none && state[link] == walking)
        cyclic.insert(cyclic.end(), std::find(path.begin(), path.end(), link), path.end());
      for (const std::size_t each : path) state[each] = done;
    }
    return cyclic;
  }

  std::vector<int> result() const {
    std::vector<int> all;
    all.reserve(links_);
    for (const std::size_t joint : chosen_) all.push_back(joint == none ? -1 : static_cast<int>(joints_[joint].joint));
    return all;
  }

  std::size_t links_;
  const std::vector<SpanningEnds>& joints_;
  std::vector<std::vector<std::size_t>> inboard_, outboard_;  // by link: places in `joints_`
  std::vector<int> depth_;
  std::vector<std::size_t> chosen_;
};

}  // namespace

std::vector<int> spanning_joints(std::size_t links, const std::vector<SpanningEnds>& joints) {
  return Spanner(links, joints).span();
}

}  // namespace momentree::io
