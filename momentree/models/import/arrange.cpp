// Builds a tree from links and joints that name each other, without recursion, since a chain may be as long as memory allows.
#include <algorithm>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include <momentree/base/error.hpp>
#include <momentree/models/import/importer.hpp>
#include <momentree/models/import/spanning.hpp>

namespace momentree::io {

namespace {

XmlLocation name_spot(XmlElement element) {
  const auto i = element.find("name");
  return {element, i ? *i : XmlLocation::no_attribute};
}

constexpr const char* tree_format =
    "the format describes trees: leave out one of these joints, and close the loop by a [[loop]] of the scenario";

class Arranger {
 public:
  Arranger(const std::vector<NamedLink>& links, const std::vector<NamedJoint>& joints, Import& import)
      : links_(links), joints_(joints), import_(import) {}

  // With a spanning tree of the joints.
  LinkTree span() {
    tree_.parent.assign(links_.size(), -1);
    note_names();
    std::vector<SpanningEnds> ends;
    for (std::size_t j = 0; j < joints_.size(); ++j)
      if (const auto each = ends_of(j)) ends.push_back({each->parent, each->child, joints_[j].rows, j});
    if (!sound_) return std::move(tree_);
    tree_.joint = spanning_joints(links_.size(), ends);
    for (const SpanningEnds& each : ends) {
      const auto child = static_cast<std::size_t>(each.child);
      if (tree_.joint[child] == static_cast<int>(each.joint))
        tree_.parent[child] = each.parent;
      else
        tree_.loops.push_back(each.joint);
    }
    put_in_order();
    return std::move(tree_);
  }

  LinkTree arrange() {
    tree_.joint.assign(links_.size(), -1);
    tree_.parent.assign(links_.size(), -1);
    note_names();
    for (std::size_t j = 0; j < joints_.size(); ++j) connect(j);
    for (const auto& [joint, parent, child] : seconds_) report_second(joint, parent, child);
    put_in_order();
    if (!sound_) tree_.order.clear();
    return std::move(tree_);
  }

 private:
  struct Ends {
    int parent, child;
  };
  struct Second {
    std::size_t joint;
    int parent, child;
  };

  void error(const XmlLocation& at, std::string what, std::string hint = {}) {
    import_.file_of(at.element).error(at, std::move(what), std::move(hint));
    sound_ = false;
  }

  std::string line_of(XmlElement element) const { return import_.file_of(element).line_of(element); }

  void note_names() {
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if (links_[i].name.empty()) continue;  // reported
      const auto [first, fresh] = by_name_.emplace(links_[i].name, i);
      if (!fresh)
        error(name_spot(links_[i].element), "duplicate link " + in_quotes(links_[i].name) +
                                                ": the name is already used by another on " +
                                                line_of(links_[first->second].element));
    }
    std::unordered_map<std::string_view, std::size_t> names;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if (joints_[j].name.empty()) continue;
      const auto [first, fresh] = names.emplace(joints_[j].name, j);
      if (!fresh)
        error(name_spot(joints_[j].element), "duplicate joint " + in_quotes(joints_[j].name) +
                                                 ": the name is already used by another on " +
                                                 line_of(joints_[first->second].element));
    }
  }

  int find(const std::string& name, const XmlLocation& at, const char* end) {
    const auto found = by_name_.find(name);
    if (found != by_name_.end()) return static_cast<int>(found->second);
    sound_ = false;
    if (name.empty()) return -1;  // reported
    std::vector<std::string> names;
    if ((suggestions_left_ -= static_cast<long>(links_.size())) > 0)
      for (const NamedLink& link : links_) names.push_back(link.name);
    error(at, std::string(end) + ": there is no link " + in_quotes(name), did_you_mean(name, names));
    return -1;
  }

  // The links of a joint; nothing, with a report, if they are not known.
  std::optional<Ends> ends_of(std::size_t j) {
    const NamedJoint& joint = joints_[j];
    const int child = find(joint.child, joint.child_spot, "child");
    const int parent = joint.from_ground ? -1 : find(joint.parent, joint.parent_spot, "parent");
    if (child < 0 || (parent < 0 && !joint.from_ground)) return {};
    if (parent != child) return Ends{parent, child};
    error(joint.child_spot, "joint " + in_quotes(joint.name) + " joins link " + in_quotes(joint.child) + " to itself");
    return {};
  }

  void connect(std::size_t j) {
    const auto ends = ends_of(j);
    if (!ends) return;
    const auto child = static_cast<std::size_t>(ends->child);
    if (tree_.joint[child] >= 0) {
      seconds_.push_back({j, ends->parent, ends->child});
    } else {
      tree_.joint[child] = static_cast<int>(j);
      tree_.parent[child] = ends->parent;
    }
  }

  const std::string& name(int link) const { return links_[static_cast<std::size_t>(link)].name; }

  // The path from a link to its root, or until it repeats.
  std::vector<int> path_up(int link) const {
    std::vector<int> path;
    std::unordered_set<int> seen;
    for (; link >= 0 && seen.insert(link).second; link = tree_.parent[static_cast<std::size_t>(link)]) path.push_back(link);
    return path;
  }

  // The beginning and the end of a long list.
  static std::string chain(const std::vector<std::string>& parts, const char* between) {
    constexpr std::size_t shown = 10;
    std::string text;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts.size() > shown + 2 && i == shown) {
        text += std::string(between) + "…";
        i = parts.size() - 2;
        continue;
      }
      text += (i == 0 ? "" : between) + parts[i];
    }
    return text;
  }

  // A link with a second inboard joint: two paths lead to it, and close a loop where they meet.
  void report_second(std::size_t j, int parent, int child) {
    const NamedJoint& joint = joints_[j];
    const NamedJoint& first = joints_[static_cast<std::size_t>(tree_.joint[static_cast<std::size_t>(child)])];
    std::string what = "link " + in_quotes(joint.child) + " has two parents: joint " + in_quotes(joint.name) + " joins it to " +
                       (parent < 0 ? "the ground" : in_quotes(joint.parent)) + ", and " + in_quotes(first.name) + " on " +
                       line_of(first.element) + " to " + (first.from_ground ? "the ground" : in_quotes(first.parent));
    std::string hint = tree_format;
    if (--loops_left_ >= 0) {
      const std::vector<int> one = path_up(child), other = path_up(parent);
      std::unordered_map<int, std::size_t> on_one;
      for (std::size_t i = 0; i < one.size(); ++i) on_one.emplace(one[i], i);
      std::size_t k = 0;
      while (k < other.size() && !on_one.contains(other[k])) ++k;
      std::size_t last = one.size();
      if (k < other.size()) last = on_one.at(other[k]) + 1;
      const bool by_ground = k == other.size() && tree_.joint[static_cast<std::size_t>(one.back())] >= 0 &&
                             (parent < 0 || tree_.joint[static_cast<std::size_t>(other.back())] >= 0);
      if (k < other.size() || by_ground) {
        std::vector<std::string> loop;
        for (std::size_t i = last; i-- > 0;) loop.push_back(in_quotes(name(one[i])));  // from the common link down to the child
        for (std::size_t i = 0; i < k; ++i) loop.push_back(in_quotes(name(other[i])));
        loop.push_back(by_ground ? "the ground" : loop.front());
        if (by_ground) loop.insert(loop.begin(), "the ground");
        std::vector<std::string> joints;
        const auto add = [&](std::size_t number) {
          joints.push_back(in_quotes(joints_[number].name) + " (" + line_of(joints_[number].element) + ")");
        };
        const auto inboard = [&](int link) { return static_cast<std::size_t>(tree_.joint[static_cast<std::size_t>(link)]); };
        for (std::size_t i = by_ground ? last : last - 1; i-- > 0;) add(inboard(one[i]));
        add(j);
        for (std::size_t i = 0; i < k; ++i) add(inboard(other[i]));
        what += ". That closes the loop " + chain(loop, " – ") + " of the joints " + chain(joints, ", ");
        hint = tree_format;
      }
    }
    error(joint.child_spot, std::move(what), std::move(hint));
  }

  void report_circle(int start, std::vector<char>& state) {
    std::string names = in_quotes(name(start));
    int shown = 1;
    for (int link = start;;) {
      state[static_cast<std::size_t>(link)] = gone;
      link = tree_.parent[static_cast<std::size_t>(link)];
      if (++shown <= 8) names += " on " + in_quotes(name(link));
      if (link == start) break;
    }
    if (shown > 8) names += " on …";
    error(joints_[static_cast<std::size_t>(tree_.joint[static_cast<std::size_t>(start)])].parent_spot,
          "the joints form a cycle: " + names, tree_format);
  }

  enum State : char { unseen, walking, placed, gone };

  void put_in_order() {
    std::vector<char> state(links_.size(), unseen);
    std::vector<std::size_t> path;
    tree_.order.reserve(links_.size());
    for (std::size_t i = 0; i < links_.size(); ++i) {
      path.clear();
      int at = static_cast<int>(i);
      while (at >= 0 && state[static_cast<std::size_t>(at)] == unseen) {
        state[static_cast<std::size_t>(at)] = walking;
        path.push_back(static_cast<std::size_t>(at));
        at = tree_.parent[static_cast<std::size_t>(at)];
      }
      if (at >= 0 && state[static_cast<std::size_t>(at)] == walking) report_circle(at, state);
      const bool connected = at < 0 || state[static_cast<std::size_t>(at)] == placed;
      for (auto link = path.rbegin(); link != path.rend(); ++link) {
        state[*link] = connected ? placed : gone;
        if (connected) tree_.order.push_back(*link);
      }
    }
  }

  const std::vector<NamedLink>& links_;
  const std::vector<NamedJoint>& joints_;
  Import& import_;
  LinkTree tree_;
  std::unordered_map<std::string_view, std::size_t> by_name_;
  std::vector<Second> seconds_;
  long suggestions_left_ = 2'000'000;
  int loops_left_ = 20;  // budget, since a path to the root may be long
  bool sound_ = true;
};

}  // namespace

LinkTree arrange(const std::vector<NamedLink>& links, const std::vector<NamedJoint>& joints, Loops loops, Import& import) {
  Arranger arranger(links, joints, import);
  return loops == Loops::closed ? arranger.span() : arranger.arrange();
}

}  // namespace momentree::io
