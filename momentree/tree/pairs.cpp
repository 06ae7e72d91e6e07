// Finds isomorphic branches of one body, or isomorphic mechanisms: the passes process them in pairs, in the two lanes of one
// scalar.
#include <algorithm>
#include <array>

#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

namespace {
constexpr int few = 3;  // bodies: shorter branches gain nothing from being paired
}

/// True if the `count` bodies from `place` on, a body and all outboard of it, are isomorphic to those from `other` on.
bool Tree::are_isomorphic(int place, int other, int count) const {
  bool any_revolute = false;
  for (int i = 0; i < count; ++i) {
    const Class& a = class_[at(order_[at(place + i)])];
    const Class& b = class_[at(order_[at(other + i)])];
    const bool revolute = a.kind == Kind::revolute && (a.variant == Variant::plain || a.variant == Variant::armature);
    any_revolute = any_revolute || revolute;
    const unsigned what =
        i == 0 ? node::leaf | node::branching : node::leaf | node::branching | node::first_child | node::last_child;
    if (!(a == b) || !(revolute || a.kind == Kind::weld) ||
        ((node_flags_[at(place + i)] ^ node_flags_[at(other + i)]) & what) != 0)
      return false;
  }
  return any_revolute;
}

/// Pairs a body and its next siblings: each with the nearest earlier isomorphic one, among the last few that are not paired yet.
/// `end`: end of their subtrees in the order.
void Tree::pair_siblings(int first, int end) {
  struct Branch {
    int place, size;
  };
  std::array<Branch, 8> waiting{};
  std::size_t count = 0;
  for (int b = first; b >= 0; b = next_sibling_[at(b)]) {
    const int place = place_[at(b)], next = next_sibling_[at(b)], size = (next < 0 ? end : place_[at(next)]) - place;
    if (size < few || (parent_[at(b)] < 0 && in_a_plane(place))) continue;  // the pass over plane mechanisms is faster
    std::size_t i = count;
    while (i > 0 && !(waiting[i - 1].size == size && are_isomorphic(waiting[i - 1].place, place, size))) --i;
    if (i == 0) {
      if (count == waiting.size()) std::copy(waiting.begin() + 1, waiting.end(), waiting.begin()), --count;
      waiting[count++] = {place, size};
    } else {
      if (!has_pairs_) pair_.assign(order_.size(), -1), end_.resize(order_.size());
      has_pairs_ = true;
      const int other = waiting[i - 1].place;
      pair_[at(place)] = other, pair_[at(other)] = place;
      end_[at(place)] = place + size, end_[at(other)] = other + size;
      std::move(waiting.begin() + static_cast<std::ptrdiff_t>(i), waiting.begin() + static_cast<std::ptrdiff_t>(count),
                waiting.begin() + static_cast<std::ptrdiff_t>(i) - 1);
      --count;
    }
  }
}

/// Uses the order, node flags and kernel runs. `any_branching`: whether any body is branching.
void Tree::find_pairs(bool any_branching) {
  const int count = static_cast<int>(order_.size());
  has_pairs_ = false;
  pair_siblings(first_root_, count);
  if (any_branching) pair_branches();
  if (has_pairs_)
    cut_runs();
  else
    paired_runs_.clear(), paired_links_.clear(), end_.clear(), pair_.clear();  // so that copies stay short
}

/// At every branching body, except in plane mechanisms and in branches that are already paired.
void Tree::pair_branches() {
  const int count = static_cast<int>(order_.size());
  end_.resize(at(count));
  int end = 0;  // end of the current body's subtree
  for (int place = 0; place < count; ++place) {
    const int b = order_[at(place)], next = next_sibling_[at(b)];
    const unsigned flags = node_flags_[at(place)];
    if ((flags & node::root) != 0)
      end = next < 0 ? count : place_[at(next)];
    else if ((flags & node::first_child) == 0 || next >= 0)
      end = end_[at(place)];
    const bool flat = (flags & node::root) != 0 && in_a_plane(place);
    if (flat || (has_pairs_ && pair_[at(place)] >= 0)) {
      place = end - 1;
    } else if ((flags & node::branching) != 0) {
      for (int c = first_child_[at(b)]; c >= 0; c = next_sibling_[at(c)])
        end_[at(place_[at(c)])] = next_sibling_[at(c)] < 0 ? end : place_[at(next_sibling_[at(c)])];
      pair_siblings(first_child_[at(b)], end);
    }
  }
}

/// Cuts the kernel runs where paired branches begin and end, and collects the constants of both.
void Tree::cut_runs() {
  paired_runs_.clear(), paired_links_.clear();
  int begin = 0, end = 0, pair = 0, links = 0;  // of the current branch; place of its partner; index of its first constants
  for (const KernelRun& whole : runs_) {
    KernelRun part = whole;
    for (int place = whole.begin; place < whole.end; ++place) {
      const bool branch = place >= end && pair_[at(place)] >= 0;
      if (branch) {
        begin = place, end = end_[at(place)], pair = pair_[at(place)];
        int& of_first = pair_[at(std::min(place, pair))];  // from here on the index of its constants instead of its partner
        if (place < pair) of_first = static_cast<int>(paired_links_.size());
        links = of_first;
      }
      if (place > whole.begin && (branch || place == end)) part.end = place, paired_runs_.push_back(part), part = whole;
      if (place == whole.begin || branch || place == end) {
        part.begin = place, part.branch = branch;
        if (place < end) part.pair = pair + place - begin, part.links = links + place - begin;
      }
      if (place < end && place < pair)
        paired_links_.emplace_back(links_[at(order_[at(place)])], links_[at(order_[at(pair + place - begin)])]);
    }
    paired_runs_.push_back(part);
  }
}

}  // namespace momentree
